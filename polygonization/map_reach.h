// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

namespace terrace {

/// How far from the camera what is known of the map.
struct MapReach {
  double window_m = std::numeric_limits<double>::infinity();  ///< evidence, from which it can still change
  double keep_beyond_m = std::numeric_limits<double>::infinity();  ///< anything at all
  double cell_size_m = 0.32;                                       ///< edge of the cells of patches
};

}  // namespace terrace
