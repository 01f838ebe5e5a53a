// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "labeling/flight_frame.h"
#include "labeling/step_elements.h"
#include "labeling/stride.h"

namespace terrace {

/// The height of a floor or a landing that a flight begins or ends at. It obeys the law as a tread would, but
/// where it begins says nothing about the run.
struct LevelHeight {
  int level = 0;  ///< 0: at the foot of step 1
  double z = 0.0;
  double sigma_m = 0.0;
};

/// One hypothesis of a flight with everything that obeys it.
struct Flight {
  FlightFramePtr frame;
  std::vector<StepElement> elements;  ///< measured in `frame`
  Stride stride;
  std::vector<StepFit> fits;
  std::vector<LevelHeight> ends;  ///< as far as they are known
  double score = 0.0;
};

/// Least squares over all members: the common rise, run and width, and again who obeys them.
void RefineFlight(const StaircaseConfig& config, Flight& flight);

/// The same flight by its own steps, and by the heights alone of floor and landing.
/// @param first, last  of the steps, as its fits count them
/// @param last_tread  the highest one that is no landing
void RefineWithin(const StaircaseConfig& config, int first, int last, int last_tread, Flight& flight);

/// The same straight flight, measured along the direction on which its risers (none: its treads) agree.
std::optional<Flight> TurnToMembers(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                                    const Flight& flight);

}  // namespace terrace
