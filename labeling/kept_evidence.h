// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/explanation.h"
#include "labeling/region_record.h"
#include "labeling/region_shape.h"
#include "labeling/staircase_tracker.h"

namespace terrace {

// The numbers that labels and staircases were decided by, as they were kept then; without words.

/// @param shape      of the polygon that the region was told of
/// @param neighbors  ascending by id
RegionExplanation ExplainRegion(const RegionRecord& record, const RegionShape& shape,
                                std::vector<NeighborRegion> neighbors);

/// @param region  one that is predicted
RegionExplanation ExplainInferredStep(const TerrainRegion& region);

StaircaseExplanation ExplainStaircase(const TrackedStaircase& staircase);

}  // namespace terrace
