// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"

namespace terrace {

/// One raw lens: rays to pixels and back, whatever its model. Rays are in the axes of the raw camera, of any
/// length; pixel centres at whole numbers.
class Lens {
 public:
  explicit Lens(const RawCamera& camera);

  /// The pixel that sees a ray; none beyond `max_angle_rad` from the axis.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& ray) const;
  /// The unit ray that a pixel sees; none where no ray lands.
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel) const;

  /// Beyond this angle the model turns back, or has no answer: what it says there is a ghost.
  double max_angle_rad() const { return max_angle_rad_; }
  /// Pixels that a ray moves on the axis, per unit of the tangent: the focal lengths of the pinhole that the
  /// lens resembles there, x and y.
  Eigen::Vector2d focal_px() const;

 private:
  /// Distance from the centre, in units of the focal length, of a ray at this angle from the axis; without
  /// what is not symmetric.
  double Radius(double angle_rad) const;
  std::optional<double> AngleOf(double radius) const;

  RawCamera camera_;
  RawCamera symmetric_;
  double max_angle_rad_ = 0.0;
  double cos_max_angle_ = 1.0;
};

/// What a lens cannot mean in an image of this size, a sentence each: wrong number of coefficients, focal
/// lengths outside the image's scale, a model that turns back in the middle of the image or stretches it
/// more than a pinhole does.
std::vector<std::string> LensProblems(const RawCamera& camera, int width, int height);

}  // namespace terrace
