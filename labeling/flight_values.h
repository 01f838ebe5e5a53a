// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "labeling/flight.h"
#include "labeling/line_fit.h"

namespace terrace {

/// What the steps say of the rise of their flight: height of level k over k.
/// @param fits  those of the flight that count
std::vector<LineValue> StepHeights(const Flight& flight, const std::vector<StepFit>& fits);

/// What they say of its run: where riser k stands over k - 1.
std::vector<LineValue> StepPlaces(const Flight& flight, const std::vector<StepFit>& fits);

}  // namespace terrace
