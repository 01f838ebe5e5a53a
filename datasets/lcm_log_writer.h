// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "datasets/ground_truth.h"
#include "datasets/lcm_event_log.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/image_codec.h"

namespace terrace {

/// Writes sensor frames as an LCM log that replays to the very same frames. Events carry the times of what
/// they hold, so that lcm-logplayer plays the log at the pace of the recording.
class LcmLogWriter {
 public:
  /// @param true_poses  ascending in time; of the body, or of the raw left camera when the calibration knows
  /// no body Throws FileError when the file cannot be made.
  LcmLogWriter(const std::filesystem::path& path, StereoCalibration calibration,
               std::vector<TimedPose> true_poses, ImageEncoding encoding, ChannelConfig channels = {});

  /// Writes the frame with its samples, the true poses up to it, and the calibration when a second has
  /// passed.
  void Add(const SensorFrame& frame);
  /// Writes the true poses behind the last frame. Throws FileError when anything could not be written.
  void Finish();

 private:
  struct Event {
    std::int64_t utime = 0;
    const std::string* channel = nullptr;
    std::vector<std::uint8_t> data;
  };

  template <typename Message>
  void Collect(Timestamp t, const std::string& channel, const Message& message);
  void CollectTruePosesUpTo(Timestamp t);
  void WriteCollected();

  LcmEventWriter log_;
  const StereoCalibration calibration_;
  const std::vector<TimedPose> true_poses_;
  const ImageEncoding encoding_;
  const ChannelConfig channels_;
  std::vector<Event> collected_;
  std::size_t next_true_pose_ = 0;
  std::optional<Timestamp> t_calibration_;
};

/// The true poses of a sequence as they go into a log; empty when there are none or their frame cannot be
/// turned into the one of the log. Throws FileError.
std::vector<TimedPose> TruePosesForLog(const TrueTrajectory& truth, const StereoCalibration& calibration);

}  // namespace terrace
