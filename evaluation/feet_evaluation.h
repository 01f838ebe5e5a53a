// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/terrain_map.h"
#include "datasets/ground_truth.h"
#include "evaluation/edge_errors.h"
#include "evaluation/true_ground.h"
#include "evaluation/well_seen.h"

namespace terrace {

/// What the map offers of one true tread.
struct TreadFeet {
  int id = 0;
  std::string name;
  double well_seen_m2 = 0.0;
  double offered_m2 = 0.0;
  double offered_pct() const { return 100.0 * offered_m2 / well_seen_m2; }
};

/// One square centimetre of the plan.
struct FootCell {
  enum class Kind { kMissed, kOffered, kUnsupported };
  Eigen::Vector2d middle;  ///< x, y in the true world
  Kind kind;
};

/// Can a foot trust the map? A foothold is a cell of 1 cm of a walkway, ramp or tread that is not predicted,
/// at least 3 cm inside its outline.
struct FeetEvaluation {
  double foothold_m2 = 0.0;  ///< of all footholds that are offered
  /// Of these: under whose disc of 2 cm no true surface lies within 2.5 cm of height.
  double unsupported_m2 = 0.0;
  double unsupported_tread_m2 = 0.0;  ///< of treads
  double unsupported_drop_m2 = 0.0;   ///< within 10 cm, seen from above, of a true drop

  double well_seen_m2 =
      0.0;                  ///< true cells of 1 cm that were well seen, at least 3 cm inside the true outline
  double offered_m2 = 0.0;  ///< of these, with a foothold over them within 2.5 cm of height
  std::vector<TreadFeet> treads;  ///< with at least 100 cm^2 well seen

  EdgeFigures edges;  ///< of walkable polygons, where the cell inside was well seen

  int num_drop_samples = 0;
  /// The farthest that an outline reaches past a true drop at its height; none when there is no drop.
  std::optional<double> drop_over_p100_m;

  std::vector<FootCell> cells;    ///< for the picture, in the order of drawing
  std::vector<DropSample> drops;  ///< likewise

  std::optional<double> unsupported_pct() const;    ///< none when nothing is offered
  std::optional<double> offered_pct() const;        ///< none when nothing was well seen
  std::optional<double> tread_offered_pct() const;  ///< mean of the treads
  std::optional<double> tread_offered_min_pct() const;
};

/// @param well_seen  cells of the truth that a mapper could see well
/// @param T_true_result  what moves the map onto the truth
FeetEvaluation EvaluateFeet(const TerrainMap& map, const TrueScene& truth, const CellsOfPolygons& well_seen,
                            const Eigen::Isometry3d& T_true_result);

}  // namespace terrace
