// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace terrace {

/// Settings of the search for staircases. YAML section: `staircases`.
struct StaircaseConfig {
  /// Lowest and highest riser of a staircase. Building codes say 10 to 22 cm; outdoor steps are lower.
  double min_riser_m = 0.05;
  double max_riser_m = 0.26;
  /// Shortest and longest tread, from riser to riser. Building codes say 22 to 36 cm.
  double min_tread_m = 0.18;
  double max_tread_m = 0.45;
  /// Less steep is a ramp or a row of kerbs, steeper a ladder.
  double min_pitch_deg = 8.0;
  double max_pitch_deg = 50.0;
  /// Narrower rows of steps are clutter.
  double min_width_m = 0.4;
  /// Staircases of which less is sure are not told.
  double min_confidence = 0.7;
  /// How far a step may lie above or below where the common rise puts it, and no more than a third of the
  /// rise.
  double height_tolerance_m = 0.035;
  /// How far an edge may lie before or behind where the common run puts it.
  double edge_tolerance_m = 0.08;
  /// How far a riser or the long side of a tread may be turned from the common direction.
  double max_turn_deg = 20.0;
  /// Treads may lean by this much.
  double max_tread_slope_deg = 12.0;

  /// What a step of this rise may be off.
  double HeightTolerance(double rise_m) const { return std::min(height_tolerance_m, rise_m / 3.0); }

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
