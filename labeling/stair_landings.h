// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "labeling/staircase_tracker.h"

namespace terrace {

/// Which shapes may be the first that is seen of the landing of a told staircase, or of a step more: supports
/// that begin where its next riser would stand, a whole number of rises above its foot. In the order of the
/// shapes.
std::vector<bool> MayBeLandings(const std::vector<const TrackedStaircase*>& staircases,
                                const std::vector<RegionShapePtr>& shapes);

}  // namespace terrace
