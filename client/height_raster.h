// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "client/query_types.h"
#include "client/terrain_query.h"

namespace terrace {

/// The highest ground in every cell of a grid, column by column through each region's outline.
HeightGrid RasterHeights(const TerrainQuery& query, const HeightGridSpec& spec);

}  // namespace terrace
