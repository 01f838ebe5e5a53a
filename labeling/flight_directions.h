// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "labeling/flight_frame.h"
#include "labeling/step_elements.h"

namespace terrace {

/// Directions in which several candidates agree to rise, most area first.
std::vector<FlightFramePtr> StraightFrames(const StaircaseConfig& config,
                                           const std::vector<RegionShapePtr>& shapes,
                                           const std::vector<StepCandidate>& candidates);

/// Axes about which two candidates may turn, either way up.
std::vector<FlightFramePtr> SpiralFrames(const StaircaseConfig& config,
                                         const std::vector<RegionShapePtr>& shapes,
                                         const std::vector<StepCandidate>& candidates);

}  // namespace terrace
