// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry.h"
#include "core/pose_estimate.h"
#include "core/time.h"

namespace terrace {

using PolygonId = std::int64_t;

/// One planar piece of the global map. Immutable; a change makes a new revision under the same id.
struct Polygon {
  PolygonId id = 0;  ///< positive; one that has gone comes back only where it lay
  int revision = 0;
  Plane plane_world;
  /// Tilt about x, tilt about y [rad], offset along the normal [m], about `centroid_world`, axes of
  /// AxesOf(normal).
  Eigen::Matrix3d plane_covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d centroid_world = Eigen::Vector3d::Zero();
  double rms_m = 0.0;
  double noise_m = 0.0;  ///< what the sensor adds to single points along the normal, standard deviation
  double area_m2 = 0.0;  ///< outline less holes
  Ring outline_world;    ///< counter-clockwise seen from where the normal points; simple; in the plane
  std::vector<Ring> holes_world;  ///< clockwise, inside the outline; simple; in the plane
  /// For each edge, outline first, then holes: one looks past the plane beyond it. Empty: not known.
  std::vector<bool> seen_past;
  double support = 0.0;  ///< share of the area with observed points, 0..1
  int num_observations = 0;
  Timestamp first_seen;
  Timestamp last_seen;
};
using PolygonPtr = std::shared_ptr<const Polygon>;

/// What one frame changed in the polygon map. Ids ascend; none is in two of the lists.
struct PolygonUpdate {
  FrameId frame_id = 0;
  Timestamp t_capture;
  std::vector<PolygonPtr> changed;  ///< as they are now: those added and revised, ascending by id
  std::vector<PolygonId> added;     ///< that were not there before
  std::vector<PolygonId> revised;   ///< with a new revision
  std::vector<PolygonId> removed;   ///< that are no longer there
  std::vector<PolygonId> seen;      ///< in view again and unchanged
};

}  // namespace terrace
