// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/terrain_map.h"

namespace terrace {

/// Of how many pieces a map is, and of what kind; needs no truth.
struct RegionCensus {
  int count = 0;  ///< regions that are not predicted
  double area_m2 = 0.0;
  int num_slivers = 0;  ///< smaller than 0.05 m^2, or narrower than 6 cm on average
  int num_unknown = 0;
  double sliver_pct() const { return count > 0 ? 100.0 * num_slivers / count : 0.0; }
  double unknown_pct() const { return count > 0 ? 100.0 * num_unknown / count : 0.0; }
};

/// The mean width of a region is twice its area over the length of its outline: that of a long strip.
RegionCensus CountRegions(const TerrainMap& map);

}  // namespace terrace
