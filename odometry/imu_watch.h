// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/sensor_frame.h"

namespace terrace {

/// Looks all the time whether an IMU still measures: readings that end at what the sensor can show are no
/// measurements, nor are those that stand still while the robot moves.
class ImuWatch {
 public:
  /// Takes in the samples since the last frame.
  /// @return why the IMU cannot be believed, as soon as that is certain
  std::optional<std::string> Read(const std::vector<ImuSample>& samples);

  /// The newest readings are all the same, bit by bit: frozen, unless it is one without noise that rests.
  bool stands() const;
  /// It has said nothing for long; true once each time. To be asked after Read(), once a frame.
  bool HasFallenSilent(Timestamp t_capture);

 private:
  /// How often one component has shown its extreme.
  struct Extreme {
    double least = 0.0, most = 0.0;
    int num_least = 0, num_most = 0;  ///< samples
    int run = 0, longest_run = 0;     ///< in a row, at either

    void Add(double value, bool first);
    bool IsClipped(double least_range, int num_samples) const;
  };

  void Compare(const ImuSample& sample);
  std::optional<std::string> Clipped();

  std::optional<ImuSample> last_;
  int num_same_ = 0;
  Timestamp t_same_;  ///< of the first of them
  bool silent_ = false;
  std::array<Extreme, 6> extremes_;  ///< of this stretch: gyroscope, then accelerometer
  int num_in_stretch_ = 0;
  Timestamp t_stretch_;
};

}  // namespace terrace
