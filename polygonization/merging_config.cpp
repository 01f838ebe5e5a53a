// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/merging_config.h"

#include "core/field_problems.h"

namespace terrace {

std::vector<std::string> MergingConfig::Problems() const {
  FieldProblems problems;
  problems.RequireAbove("max_offset_m", max_offset_m, 0.0);
  problems.RequireInside("max_angle_deg", max_angle_deg, 0.0, 45.0);
  problems.RequireAbove("max_gap_m", max_gap_m, 0.0);
  problems.RequireAtLeast("min_width_m", min_width_m, 0.0);
  problems.RequireAbove("min_area_m2", min_area_m2, 0.0);
  problems.RequireAbove("outline_resolution_m", outline_resolution_m, 0.0);
  problems.RequireAbove("simplify_m", simplify_m, 0.0);
  problems.RequireWithin("max_vertices", max_vertices, 16, 5000);
  problems.RequireAbove("min_change_m", min_change_m, 0.0);
  problems.RequireAtLeast("max_extent_m", max_extent_m, 2.0);
  return problems.Take();
}

}  // namespace terrace
