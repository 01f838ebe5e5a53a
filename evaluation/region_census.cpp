// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/region_census.h"

#include <cstddef>

namespace terrace {
namespace {

constexpr double kSliver_m2 = 0.05;
constexpr double kSliverWidth_m = 0.06;

double LengthOf(const Ring& ring) {
  double length_m = 0.0;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++)
    length_m += (ring[i] - ring[j]).norm();
  return length_m;
}

}  // namespace

RegionCensus CountRegions(const TerrainMap& map) {
  RegionCensus census;
  for (const auto& region : map.regions) {
    if (region->predicted()) continue;
    ++census.count;
    census.area_m2 += region->area_m2;
    const bool narrow = 2.0 * region->area_m2 < kSliverWidth_m * LengthOf(region->outline_world);
    census.num_slivers += region->area_m2 < kSliver_m2 || narrow;
    census.num_unknown += region->label == TerrainLabel::kUnknown;
  }
  return census;
}

}  // namespace terrace
