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
  double height_sigma_m = 0.0;                     ///< of a tread its level, of a face its top
  double front_sigma_m = 0.0;                      ///< of a tread its front, of a face its place
  Eigen::Vector2d view = Eigen::Vector2d::Zero();  ///< unit vector from the eye to it in the plan
};

/// How well the height of a level piece is known at best.
constexpr double kLevelHeightSigma_m = 0.006;

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

}  // namespace terrace
