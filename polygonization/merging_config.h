// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

/// Settings of merging patches into polygons. YAML section: `merging`.
struct MergingConfig {
  /// Patches belong to a neighbouring surface within this offset and angle, and what their noise adds to
  /// them.
  double max_offset_m = 0.015;
  double max_angle_deg = 10.0;
  /// Surfaces whose pieces lie farther apart than this are two; narrower gaps and holes are closed.
  double max_gap_m = 0.06;
  /// Narrower tongues of an outline are cut off.
  double min_width_m = 0.025;
  /// Polygons smaller than this are not published, nor holes that nothing was seen through; nor are polygons
  /// smaller than the square of six times their noise.
  double min_area_m2 = 0.015;
  /// Edge of the cells in which the evidence of pixels for a surface is kept, and outlines are traced.
  double outline_resolution_m = 0.01;
  /// How far a simplified edge of an outline may leave the traced one.
  double simplify_m = 0.015;
  /// Vertices of one polygon, so that it fits a message; a more ragged one is simplified further, as far as
  /// its rings allow without touching.
  int max_vertices = 2000;
  /// A polygon gets a new revision when its plane moved by this much inside its outline, or its area changed
  /// by as much along its edges.
  double min_change_m = 0.001;
  /// A surface grows no farther than this along each axis of the world, so that a change costs no more in a large
  /// place than in a small one; beyond, another one goes on.
  double max_extent_m = 20.0;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
