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
  /// high as the tread. Or, as a riser, a face that has merged with what shows of the treads beside it: its
  /// middle is that of the face. Evidence of a step, but no region to step on.
  bool leaning = false;
  /// A board seen from below. Evidence of a step as well, and no region to step on.
  bool underside = false;
  /// A level piece deeper than a tread. Where its edge is seen from above, the highest riser stands there.
  bool landing = false;
  double height_sigma_m = 0.0;                    ///< of a tread its level, of a face its top
  double front_sigma_m = 0.0;                     ///< of a tread its front, of a face its place
  Eigen::Vector2d eye = Eigen::Vector2d::Zero();  ///< where the camera was, in the plan
};

/// How well the height of a level piece is known: no better than its points agree on it, and than it is
/// level, for what was merged with it pulls at it.
double LevelHeightSigma(const RegionShape& shape);

/// What may be riser or tread, by its own form alone.
/// @param eye  where the camera is
std::vector<StepCandidate> StepCandidates(const StaircaseConfig& config,
                                          const std::vector<RegionShapePtr>& shapes,
                                          const Eigen::Vector3d& eye);

/// A candidate measured along a flight.
struct StepElement : StepCandidate {
  bool seen_from_uphill = false;
  Interval along;  ///< of a riser: its middle, twice
  Interval lateral;
  Interval heights;
  double z = 0.0;  ///< middle height of a riser, mean height of a tread; over an underside that of the tread
  double area_m2 = 0.0;
  double min_rise_m = 0.0;  ///< of an incline: lower steps would not show in it
};

/// The candidates that lie across the flight as its steps would.
std::vector<StepElement> MeasureSteps(const StaircaseConfig& config,
                                      const std::vector<RegionShapePtr>& shapes,
                                      const std::vector<StepCandidate>& candidates, const FlightFrame& frame);

/// Measures landings anew where a flight meets them: beside it they may end elsewhere.
void MeasureLandings(const std::vector<RegionShapePtr>& shapes, const FlightFrame& frame,
                     const Interval& lateral, std::vector<StepElement>& elements);

}  // namespace terrace
