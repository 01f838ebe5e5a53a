// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "labeling/flight.h"

namespace terrace {

/// The stride that most candidates obey along a frame: every pair of two risers or two treads proposes one.
std::optional<Flight> BestFlight(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                                 const std::vector<StepCandidate>& candidates, const FlightFramePtr& frame);

/// A flight that was found before, as the candidates have it now.
std::optional<Flight> FollowFlight(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                                   const std::vector<StepCandidate>& candidates, const FlightModel& known);

}  // namespace terrace
