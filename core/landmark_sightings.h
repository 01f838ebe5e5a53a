// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace terrace {

/// What became of a landmark of the odometry in one frame.
enum class LandmarkFate {
  kAgrees = 0,    ///< found, and the pose agrees
  kRejected = 1,  ///< found where it cannot be, if the pose is right
  kCreated = 2,   ///< begins with this keyframe
};
inline constexpr LandmarkFate kLandmarkFates[] = {LandmarkFate::kAgrees, LandmarkFate::kRejected,
                                                  LandmarkFate::kCreated};
const char* Name(LandmarkFate fate);  ///< "agrees", "rejected", "created"

struct LandmarkSighting {
  std::int64_t landmark = 0;                        ///< its id
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  ///< on the rectified left image
  LandmarkFate fate = LandmarkFate::kAgrees;
};

/// The landmarks of one frame.
struct FrameSightings {
  bool is_keyframe = false;
  std::vector<LandmarkSighting> landmarks;
};

}  // namespace terrace
