// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "labeling/flight.h"
#include "labeling/flight_ends.h"
#include "labeling/sight.h"
#include "labeling/staircase_finder.h"

namespace terrace {

/// The staircase that a flight is, when there is evidence enough for it. Direction, rise, run and place can
/// be chosen so that almost any three shapes obey: floor and landing in their places, faces that reach from
/// one step to the next and sides that agree are evidence as well. What the camera cannot see is not missed.
/// @param known  it was found before: then it needs less support to stay
std::optional<FoundStaircase> WeighFlight(const StaircaseConfig& config,
                                          const std::vector<RegionShapePtr>& shapes, const Flight& flight,
                                          const FlightEnds& ends, const Sight& sight, bool known);

}  // namespace terrace
