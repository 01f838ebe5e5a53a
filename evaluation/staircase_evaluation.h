// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/terrain_map.h"
#include "datasets/ground_truth.h"
#include "results/replay_result.h"

namespace terrace {

/// How well one true staircase was found; errors are result less truth and mean nothing when it was not.
struct StaircaseMatch {
  int true_id = 0;
  std::optional<std::int64_t> result_id;
  int num_risers_true = 0;
  int num_risers_error = 0;
  double riser_error_m = 0.0;
  double tread_error_m = 0.0;
  double width_error_m = 0.0;
  double direction_error_deg = 0.0;
  double base_error_m = 0.0;  ///< horizontal distance of the middles of the foot edges
  /// Horizontal distance of the camera from the nearer of foot and head edge when a staircase was first
  /// reported there, and when it was first right: all risers counted, riser within 2 cm, tread within 4 cm,
  /// direction within 10 deg.
  std::optional<double> first_reported_m;
  std::optional<double> first_right_m;
};

struct StaircaseEvaluation {
  int num_true = 0;  ///< with at least two polygons seen
  int num_result = 0;
  int num_found = 0;
  double precision = 0.0;  ///< found over reported; 1 when none was reported
  double recall = 0.0;     ///< found over true; 1 when there is none
  std::vector<StaircaseMatch> matches;
};

/// @param T_true_result  as for EvaluateMap.
/// @param true_left      true poses of the left camera, ascending in time; for the distances.
StaircaseEvaluation EvaluateStaircases(const std::vector<Staircase>& staircases,
                                       const std::vector<StaircaseReport>& reports, const TrueScene& truth,
                                       const Eigen::Isometry3d& T_true_result,
                                       const std::vector<TimedPose>& true_left);

}  // namespace terrace
