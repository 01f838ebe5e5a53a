// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "evaluation/feet_evaluation.h"

namespace terrace {

/// What feet can trust of the map of a result, and of an elevation map fed with the same disparities and
/// poses.
struct Yardstick {
  int num_images = 0;  ///< disparity images that were fused
  FeetEvaluation ours;
  FeetEvaluation elevation_map;
};

/// The result must hold its disparity images (`terraced replay --save-disparity 1`; fewer make the elevation
/// map poorer than it is) and the sequence a true scene with label images. Throws FileError.
Yardstick EvaluateYardstick(const std::filesystem::path& result, const std::filesystem::path& sequence);

/// Both side by side.
std::string ToTable(const Yardstick& yardstick);

}  // namespace terrace
