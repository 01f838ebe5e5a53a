// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace terrace {

/// What can be asked for beside what the daemon sends by itself. The numbers are those of
/// terrain_request_v1_t.
enum class RequestKind : std::int8_t {
  kHeightMap = 1,
  kOctree = 2,
  kDisparity = 3,
  kMap = 4,
};

/// Asks for one answer, or for answers at a rate for a while.
struct TerrainRequest {
  std::int64_t id = 0;  ///< a later request with the same one takes the place of this one
  RequestKind kind = RequestKind::kHeightMap;
  double rate_hz = 0.0;                                             ///< 0: one answer
  std::chrono::nanoseconds duration = std::chrono::nanoseconds(0);  ///< then the answers end; with a rate
  bool around_robot = false;  ///< the box is counted from the left camera, axes of the world
  Eigen::AlignedBox3d box;    ///< [m]; of no meaning for a disparity image
  double resolution_m = 0.0;  ///< edge of a cell of the height map
};

}  // namespace terrace
