// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

namespace terrace {

/// Compares how an IMU turns with how the images turn, over the last seconds of turning. A wrong unit, sign,
/// axis or clock is wrong by a share of every turn, and the size of the share says which of them it is.
class TurnComparison {
 public:
  /// Rotation vectors of the camera since a frame before.
  void Hear(const Eigen::Vector3d& by_imu_rad, const Eigen::Vector3d& by_images_rad, double dt_s);
  void Reset() { *this = {}; }

  /// Why the IMU cannot be believed, when its turns are not those of the images.
  std::optional<std::string> Problem() const;

 private:
  // Sums that forget, of products of the two [rad^2].
  double images_images_ = 0.0, imu_images_ = 0.0, apart_apart_ = 0.0;
  int num_turns_ = 0;  ///< frames that turned
};

}  // namespace terrace
