// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "labeling/flight.h"

namespace terrace {

/// Where a flight begins and ends: its steps are those from `first_step` to `last_step`.
struct FlightEnds {
  std::optional<int> foot_shape;     ///< floor before the first riser
  std::optional<int> head_shape;     ///< landing above the last riser
  std::vector<LevelHeight> heights;  ///< of both, where they meet the flight
  int first_step = 0;                ///< counted as the flight's fits count
  int last_step = 0;
  bool ends_with_tread = false;  ///< a tread lies above the last riser, not a landing
  int num_merged = 0;            ///< steps above the last one that have merged into one incline from afar

  int num_risers() const { return last_step - first_step + 1; }
  int num_treads() const { return ends_with_tread ? num_risers() : num_risers() - 1; }
};

/// Cuts a chain of steps where two levels in a row are missing, and keeps the piece with most elements.
void KeepLongestRun(std::vector<StepFit>& fits);

/// The floor at the foot and the landing at the head of a flight that has fits.
/// @param ground_z  of the ground that the robot stands on: a level piece so high is floor, however small
FlightEnds FindFlightEnds(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                          const Flight& flight, double ground_z);

}  // namespace terrace
