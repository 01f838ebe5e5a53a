// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "labeling/flight_frame.h"
#include "labeling/step_elements.h"

namespace terrace {

/// The part of a flight's law that is searched for when direction or axis are given.
struct Stride {
  double along0 = 0.0;  ///< of riser 1
  double run = 0.0;
  double z0 = 0.0;  ///< foot of riser 1
  double rise = 0.0;
  Interval lateral;

  /// Where riser k stands.
  double EdgeAt(double k) const { return along0 + (k - 1.0) * run; }
  bool Plausible(const StaircaseConfig& config) const;
};

/// An element that obeys a stride.
struct StepFit {
  int element = 0;
  int step_index = 0;
  double quality = 0.0;  ///< 1 perfect, 0 at the tolerance
};

/// The step as which an element obeys a stride; none when it does not.
std::optional<StepFit> FitStep(const StaircaseConfig& config, const FlightFrame& frame, const Stride& stride,
                               const StepElement& element);

/// How much of a flight is there: each riser and each tread counts once, however many fragments it has.
/// @param fits  null, or where all elements that obey are added
double FitSteps(const StaircaseConfig& config, const FlightFrame& frame, const Stride& stride,
                const std::vector<StepElement>& elements, std::vector<StepFit>* fits);

}  // namespace terrace
