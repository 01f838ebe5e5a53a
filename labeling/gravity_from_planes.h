// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/pose_estimate.h"
#include "odometry/gravity_keeper.h"
#include "polygonization/polygon.h"

namespace terrace {

/// A better "up" from what the robot walks on: the mean normal, weighed by information, of the large planes
/// that lie within a few degrees of level (within 45 deg of the camera's -y while up is only assumed). None
/// when there is no such plane. A hint about levelness only: it cannot tell a slope from a leaning world, so
/// its sigma is never better than floors are level.
std::optional<GravityHint> GravityFromPlanes(const PolygonUpdate& polygons, const PoseEstimate& pose,
                                             const Gravity& gravity);

}  // namespace terrace
