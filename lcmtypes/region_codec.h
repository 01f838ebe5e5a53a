// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <terrace/region_v1_t.hpp>
#include <terrace/staircase_v1_t.hpp>

#include "core/pose_estimate.h"
#include "core/terrain_map.h"

namespace terrace {

/// The region whole. The plane frame has its origin at centroid_world and the axes of AxesOf(normal), so that
/// the covariance travels as it is.
region_v1_t ToMessage(const TerrainRegion& region, const Gravity& gravity);
/// Of a region that came whole.
std::optional<TerrainRegion> FromMessage(const region_v1_t& message);

/// The region in pieces of at most `max_bytes` each, one when it fits. A piece holds one vertex or more,
/// however small max_bytes is.
std::vector<region_v1_t> RegionPieces(const TerrainRegion& region, const Gravity& gravity,
                                      std::size_t max_bytes);
/// Of all pieces, in their order.
std::optional<TerrainRegion> RegionFromPieces(std::span<const region_v1_t* const> pieces);

/// Without region_ids: they are those of the regions that carry its id.
staircase_v1_t ToMessage(const Staircase& staircase);
std::optional<Staircase> FromMessage(const staircase_v1_t& message);

}  // namespace terrace
