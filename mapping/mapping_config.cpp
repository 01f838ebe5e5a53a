// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/mapping_config.h"

#include <bit>

#include "core/print.h"
#include "mapping/leaf_address.h"

namespace terrace {

std::vector<std::string> MappingConfig::Problems() const {
  std::vector<std::string> problems;
  if (!(leaf_size_m >= 0.002 && leaf_size_m <= 1.0))
    problems.push_back("leaf_size_m must be between 0.002 and 1");
  if (leaves_per_cell < 4 || leaves_per_cell > 64 || !std::has_single_bit(unsigned(leaves_per_cell)))
    problems.push_back("leaves_per_cell must be 4, 8, 16, 32 or 64");
  if (!(min_leaf_px >= 1.0 && min_leaf_px <= 100.0))
    problems.push_back("min_leaf_px must be between 1 and 100");
  if (min_points < 1) problems.push_back("min_points must be at least 1");
  if (min_frames < 1) problems.push_back("min_frames must be at least 1");
  if (!(min_hit_share >= 0.0 && min_hit_share < 1.0))
    problems.push_back("min_hit_share must be at least 0 and below 1");
  if (!(depth_sigma_factor > 0.0 && depth_sigma_factor <= 100.0))
    problems.push_back("depth_sigma_factor must be above 0 and at most 100");
  if (!(pose_sigma_m > 0.0 && pose_sigma_m <= 1.0))
    problems.push_back("pose_sigma_m must be above 0 and at most 1");
  if (memory_frames < 2 || memory_frames > 250) problems.push_back("memory_frames must be between 2 and 250");
  if (!(free_margin_px > 0.0)) problems.push_back("free_margin_px must be above 0");
  if (free_frames < 1 || free_frames > 100) problems.push_back("free_frames must be between 1 and 100");
  if (!(window_m >= 1.0)) problems.push_back("window_m must be at least 1");
  if (!(keep_beyond_m == 0.0 || keep_beyond_m >= window_m))
    problems.push_back("keep_beyond_m must be 0 or at least window_m");
  if (leaf_size_m > 0.0 && window_m > kMaxReachLeaves * leaf_size_m) {
    problems.push_back(Printed("window_m must not be above %g, which is how far %d leaves reach",
                               kMaxReachLeaves * leaf_size_m, kMaxReachLeaves));
  }
  return problems;
}

}  // namespace terrace
