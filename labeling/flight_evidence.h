// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "labeling/flight.h"
#include "labeling/flight_ends.h"
#include "labeling/staircase_finder.h"

namespace terrace {

/// The staircase that a flight is, when there is evidence enough for it.
/// @param known  it was found before: then it needs less support to stay
std::optional<FoundStaircase> WeighFlight(const StaircaseConfig& config, const Flight& flight,
                                          const FlightEnds& ends, bool known);

}  // namespace terrace
