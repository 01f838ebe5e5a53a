// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <compare>
#include <vector>

#include "client/flat_polygon.h"
#include "core/terrain_map.h"

namespace terrace {

/// How far a foot's middle stays from each kind of edge [m].
struct EdgeMargins {
  double all_m = 0.0;   ///< from every edge
  double drop_m = 0.0;  ///< from drops, at least all_m
  double rise_m = 0.0;  ///< from rises, at least all_m

  friend auto operator<=>(const EdgeMargins&, const EdgeMargins&) = default;
};

/// The polygon less what is nearer to an edge than the margin of the edge's kind. Corners are rounded; what
/// is kept is never nearer, and at most 1 mm further away than asked.
/// @param edges  one for each edge of the polygon
FlatPolygon InsetOf(const FlatPolygon& polygon, const std::vector<RegionEdge>& edges,
                    const EdgeMargins& margins);

/// What of `polygon` lies in none of `parts`: counter-clockwise rings, and clockwise ones for holes in them.
FlatPolygon Without(const FlatPolygon& polygon, const std::vector<FlatRing>& parts);

/// The part of the polygon that lies in any of `parts`, rings as above.
FlatPolygon Within(const FlatPolygon& polygon, const std::vector<FlatRing>& parts);
/// The part within an axis-aligned box or any other convex counter-clockwise ring.
FlatPolygon Within(const FlatPolygon& polygon, const FlatRing& convex);

}  // namespace terrace
