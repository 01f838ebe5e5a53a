// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "labeling/region_shape.h"
#include "labeling/staircase_config.h"

namespace terrace {

/// What is seen of an incline says about it.
enum class SlopeEvidence {
  kPlane,        ///< steps of the smallest riser would show, and do not
  kNotResolved,  ///< steps may hide in the noise
  kNotPlane,     ///< it departs from its plane by more than noise does
};

/// The lowest steps that would show in an incline, seen as it was [m]. Steps of height h on a slope s leave
/// their plane by up to h cos(s) / 2 to either side; noise hides what is less than three of its standard
/// deviations. As the noise of a depth grows with its square, so does this height.
double LowestStepThatShows(const RegionShape& shape);

/// True when its slope is one that stairs have.
bool SteepAsStairs(const RegionShape& shape, const StaircaseConfig& stairs);

/// True when a staircase, seen badly, could look like this: as steep as stairs are, and higher than one step.
bool CouldBeStairs(const RegionShape& shape, const StaircaseConfig& stairs);

/// True when the points of an incline scatter by more than noise and worn or uneven surfaces explain: level
/// strips of it do, whatever their noise hides.
bool DepartsFromPlane(const RegionShape& shape, const StaircaseConfig& stairs);

SlopeEvidence JudgeSlope(const RegionShape& shape, const StaircaseConfig& stairs);

}  // namespace terrace
