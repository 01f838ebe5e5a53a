// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "labeling/flight_frame.h"
#include "labeling/region_shape.h"
#include "labeling/staircase_config.h"

namespace terrace {

/// A shape that may be a step.
struct StepCandidate {
  int shape = 0;
  bool riser = false;
  bool spiral_only = false;  ///< too deep for a straight tread, but a wedge is deeper at its outer end
  /// Strips of treads that merged into one incline, seen over the edges of the steps above: its middle is as
  /// high as the tread. Evidence of a step, but no region to step on.
  bool leaning = false;
  /// A board seen from below. Evidence of a step as well, and no region to step on.
  bool underside = false;
};

/// What may be riser or tread, by its own form alone.
std::vector<StepCandidate> StepCandidates(const StaircaseConfig& config,
                                          const std::vector<RegionShapePtr>& shapes);

/// A candidate measured along a flight.
struct StepElement {
  int shape = 0;
  bool riser = false;
  bool leaning = false;
  bool underside = false;
  Interval along;  ///< of a riser: its middle, twice
  Interval lateral;
  Interval heights;
  double z = 0.0;  ///< middle height of a riser, mean height of a tread; over an underside that of the tread
  double area_m2 = 0.0;
  double min_rise_m = 0.0;  ///< of an incline: lower steps would not show in it

  /// Its height is that of the tread only about.
  bool RoughHeight() const { return riser || leaning || underside; }
};

/// The candidates that lie across the flight as its steps would.
std::vector<StepElement> MeasureSteps(const StaircaseConfig& config,
                                      const std::vector<RegionShapePtr>& shapes,
                                      const std::vector<StepCandidate>& candidates, const FlightFrame& frame);

}  // namespace terrace
