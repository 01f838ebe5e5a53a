// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "core/statistics.h"
#include "core/time.h"
#include "daemon/live_config.h"
#include "stereo/rectifier.h"
#include "tools/finding.h"

namespace terrace {

/// Watches the inputs of a daemon for some seconds and says what is wrong with their rates, their stamps and
/// their content. `t_arrival` is on the clock of this computer.
class InputWatch {
 public:
  explicit InputWatch(const LiveConfig& config) : config_(config) {}

  /// When a pair arrived; whatever is in it.
  void AddImageStamp(Timestamp t_capture, Timestamp t_arrival);
  /// A pair to look at. Some, spread over the time, are enough.
  void AddPair(StereoPair pair);
  void AddImu(const ImuSample& sample, Timestamp t_arrival);

  std::vector<Finding> JudgeStamps() const;
  std::vector<Finding> JudgeImu() const;
  /// Brightness and sharpness of the pairs; with a calibration their size and rows, too.
  std::vector<Finding> JudgePairs(const std::optional<StereoCalibration>& calibration,
                                  const RectifierConfig& rectifier) const;

 private:
  struct Stamp {
    Timestamp t;
    Timestamp t_arrival;
  };
  /// For each pair how long after it the first IMU sample came that is not older [s].
  std::vector<double> ImuDelays() const;

  const LiveConfig config_;
  std::vector<Stamp> images_;
  std::vector<Stamp> imu_;
  std::vector<double> accel_norms_;
  std::vector<double> gyro_norms_;
  std::vector<StereoPair> pairs_;
};

/// How much finer the detail of an image is than that of its half: about 1 for a sharp one, less for a
/// blurred one. 0 where nothing is to be seen.
double Sharpness(const GrayImage& image);

}  // namespace terrace
