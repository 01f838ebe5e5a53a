// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/terrain_map.h"
#include "daemon/map_placing.h"

namespace terrace {

/// What is seen says about where a loaded map lies.
struct MapAlignment {
  MapPlace place;           ///< the prior and what is seen, weighed by their covariances
  double agrees_m2 = 0.0;   ///< of what both show, within the noise of both
  double differs_m2 = 0.0;  ///< of what both show, further apart than that
  /// Whether what is seen fixes the place in all six ways and hardly anything speaks against it.
  bool confirmed = false;
  std::string reason;  ///< why not; empty: confirmed
};

/// Moves a loaded map onto what is seen: the planes of decided regions that overlap shall be the same, each
/// by its own covariance (Gauss-Newton from the prior, unlikely pairs weighed less). Planes of one direction
/// leave the place along them to the prior; outlines are not used, since they end where the view did.
/// @param body_world  where the place has to be exact
MapAlignment Align(const std::vector<TerrainRegion>& loaded_map, const MapPlace& prior,
                   const TerrainMap& seen, const Eigen::Vector3d& body_world);

}  // namespace terrace
