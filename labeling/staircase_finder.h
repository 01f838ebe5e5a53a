// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "labeling/surface.h"

namespace terrace {

/// Settings of the search for staircases. YAML section: `staircases`.
struct StaircaseConfig {
  /// Lowest and highest riser of a staircase. Building codes say 10 to 22 cm; outdoor steps are lower.
  double min_riser_m = 0.09;
  double max_riser_m = 0.25;
  /// Shortest and longest tread, from riser to riser. Building codes say 22 to 36 cm.
  double min_tread_m = 0.18;
  double max_tread_m = 0.45;
  /// Less steep is a ramp or a row of kerbs, steeper a ladder.
  double min_pitch_deg = 15.0;
  double max_pitch_deg = 50.0;
  /// Narrower rows of steps are clutter.
  double min_width_m = 0.4;
  /// Staircases of which less is sure are not told.
  double min_confidence = 0.7;
  /// How far a step may lie above or below where the common rise puts it.
  double height_tolerance_m = 0.035;
  /// How far an edge may lie before or behind where the common run puts it.
  double edge_tolerance_m = 0.08;
  /// How far a riser or the long side of a tread may be turned from the common direction.
  double max_turn_deg = 20.0;
  /// Treads may lean by this much.
  double max_tread_slope_deg = 12.0;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// The law that all steps of a flight obey. Riser k = 1, 2, ... stands at run * (k - 1) past the foot edge
/// and reaches from z = foot_z + rise * (k - 1) to foot_z + rise * k; tread k begins there.
struct FlightModel {
  bool spiral = false;
  /// Straight: unit vector up the stairs in the plan. Spiral: unit vector from the axis along riser 1.
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  /// Straight: any point of the foot edge's line. Spiral: the axis.
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double foot_z = 0.0;
  double rise_m = 0.0;
  double run_m = 0.0;      ///< spiral: at radius_m
  double radius_m = 0.0;   ///< spiral: of the middle of the width
  double turn_sign = 1.0;  ///< spiral: +1 turns left going up
  Interval lateral;        ///< straight: to the left of the origin; spiral: distance from the axis

  /// Where riser k (1 = foot) stands at a lateral position, and its direction up.
  Eigen::Vector2d EdgePoint(double k, double lateral_m) const;
  Eigen::Vector2d UpAt(double k) const;
};

/// One surface in its place in a flight.
struct StepMember {
  int surface = 0;  ///< index into the surfaces searched
  bool riser = false;
  int step_index = 0;  ///< riser 1 is the lowest, tread 1 lies above riser 1
};

/// A staircase among the surfaces of one map.
struct FoundStaircase {
  FlightModel model;
  int num_risers = 0;
  int num_treads = 0;
  double rise_sigma_m = 0.0;
  double run_sigma_m = 0.0;
  double confidence = 0.0;
  std::vector<StepMember> members;  ///< ascending by surface
  std::optional<int> foot_surface;  ///< floor before riser 1
  std::optional<int> head_surface;  ///< landing above the last riser
};

/// Finds flights of steps: all risers and treads of one flight together obey one FlightModel.
class StaircaseFinder {
 public:
  explicit StaircaseFinder(const StaircaseConfig& config) : config_(config) {}

  /// @param known  flights found before: they are looked for first, and need less support to stay
  /// @param compete  known flights must stand against new ones; else only what they leave is searched, which
  /// is
  ///                 much quicker
  std::vector<FoundStaircase> Find(const std::vector<SurfacePtr>& surfaces,
                                   const std::vector<FlightModel>& known, bool compete) const;

 private:
  StaircaseConfig config_;
};

}  // namespace terrace
