// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "labeling/region_shape.h"

namespace terrace {

/// Compares the height of the body above the ground that the images show with what the settings say. The
/// ground under the robot is never seen, and what is near it may be a step higher or lower: only a height
/// that stays the same while the robot walks is the body's, unless nothing at all is seen at the height that
/// the settings say.
class BodyHeightCheck {
 public:
  explicit BodyHeightCheck(double body_height_m) : body_height_m_(body_height_m) {}

  /// @param body        origin of the body, level frame
  /// @param at_feet     ground was seen, now or before, at the height that the settings say
  /// @return a sentence, when it has just become certain that they disagree; told once
  std::optional<std::string> Look(const std::vector<RegionShapePtr>& shapes, const Eigen::Vector3d& body,
                                  bool at_feet);

 private:
  std::optional<std::string> Judge(bool at_feet);

  double body_height_m_;
  std::vector<double> heights_m_;        ///< of the last frames that showed large level ground nearby
  std::vector<Eigen::Vector2d> places_;  ///< where the robot was then
  int num_without_ground_ = 0;           ///< of the last frames, in a row, without ground at its feet
  bool told_ = false;
};

}  // namespace terrace
