// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/geometry.h"
#include "labeling/region_shape.h"
#include "labeling/staircase_tracker.h"

namespace terrace {

/// A tread or a riser, or the strip of landing behind the last riser (tread number `num_risers`), as the law
/// of its flight demands it where nothing was seen. Level frame.
struct InferredStep {
  bool riser = false;
  int step_index = 0;
  Plane plane;
  Ring outline;                 ///< counter-clockwise seen from where the normal points
  double height_sigma_m = 0.0;  ///< of its height, grows with the distance from what was seen of the flight
  double place_sigma_m = 0.0;   ///< of its place along the flight, likewise
};

/// All that a flight's law demands and nothing contradicts, ascending by step: a tread where neither it nor
/// anything higher or lower was seen, as large a rectangle of it as that leaves; a riser where others of the
/// flight were seen, so that it has risers.
/// @param shapes  what was seen near the flight
std::vector<InferredStep> InferSteps(const TrackedStaircase& staircase,
                                     const std::vector<RegionShapePtr>& shapes);

}  // namespace terrace
