// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/time.h"

namespace terrace {

/// One frame that has both a true pose and one of the result, each in its own world.
struct PosePair {
  Timestamp t;
  Eigen::Isometry3d T_result_left = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_true_left = Eigen::Isometry3d::Identity();
};

/// T_true_result that makes the squared distances of the positions least: rotation and translation, no scale
/// (Umeyama 1991). Needs at least one pair; the rotation of positions on one line is only one of many.
Eigen::Isometry3d AlignByPositions(const std::vector<PosePair>& pairs);

/// T_true_result that makes the first poses equal.
Eigen::Isometry3d AlignByFirstPose(const std::vector<PosePair>& pairs);

/// T_true_result with the one rotation nearest, by squared matrix difference, to what turns each orientation
/// of the result into the true one, then the translation that makes the mean positions equal.
Eigen::Isometry3d AlignByOrientations(const std::vector<PosePair>& pairs);

}  // namespace terrace
