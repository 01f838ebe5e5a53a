// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/mapping_config.h"

#include <bit>

#include "core/field_problems.h"
#include "core/print.h"
#include "mapping/leaf_address.h"

namespace terrace {

std::vector<std::string> MappingConfig::Problems() const {
  FieldProblems problems;
  problems.RequireWithin("leaf_size_m", leaf_size_m, 0.002, 1.0);
  problems.Require(
      leaves_per_cell >= 4 && leaves_per_cell <= 64 && std::has_single_bit(unsigned(leaves_per_cell)),
      "leaves_per_cell", leaves_per_cell, "be 4, 8, 16, 32 or 64");
  problems.RequireWithin("min_leaf_px", min_leaf_px, 1.0, 100.0);
  problems.RequireAtLeast("min_points", min_points, 1);
  problems.RequireAtLeast("min_frames", min_frames, 1);
  problems.Require(min_hit_share >= 0.0 && min_hit_share < 1.0, "min_hit_share", min_hit_share,
                   "be at least 0, below 1");
  problems.RequireUpTo("depth_sigma_factor", depth_sigma_factor, 0.0, 100.0);
  problems.RequireUpTo("pose_sigma_m", pose_sigma_m, 0.0, 1.0);
  problems.RequireWithin("memory_frames", memory_frames, 2, 250);
  problems.RequireAbove("free_margin_px", free_margin_px, 0.0);
  problems.RequireWithin("free_frames", free_frames, 1, 100);
  problems.RequireAtLeast("window_m", window_m, 1.0);
  problems.Require(keep_beyond_m == 0.0 || keep_beyond_m >= window_m, "keep_beyond_m", keep_beyond_m,
                   "be 0 or at least window_m");
  const double reach_m = kMaxReachLeaves * leaf_size_m;
  problems.Require(!(leaf_size_m > 0.0 && window_m > reach_m), "window_m", window_m,
                   Printed("not be above %g, which is how far %d leaves reach", reach_m, kMaxReachLeaves));
  return problems.Take();
}

}  // namespace terrace
