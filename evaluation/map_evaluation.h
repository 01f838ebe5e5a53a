// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/terrain_map.h"
#include "datasets/ground_truth.h"
#include "evaluation/edge_errors.h"
#include "evaluation/map_shapes.h"

namespace terrace {

/// How well one true polygon was found. Only polygons with a seen cell have one.
struct PolygonEvaluation {
  int id = 0;
  std::string name;
  std::string label;
  double seen_m2 = 0.0;
  double covered_m2 = 0.0;
  double correct_m2 = 0.0;    ///< covered with the right label
  double plane_rms_m = 0.0;   ///< over covered cells
  double plane_bias_m = 0.0;  ///< mean, positive when the result lies on the side the true normal points to
  double normal_deg = 0.0;    ///< mean over covered cells
  int num_regions = 0;        ///< that take at least a tenth of the covered cells
  std::string label_found;    ///< most frequent over covered cells; empty when none is covered
  EdgeFigures edges;
  double coverage() const { return seen_m2 > 0.0 ? covered_m2 / seen_m2 : 0.0; }
};

struct LabelEvaluation {
  double true_m2 = 0.0;     ///< true cells of the label
  double correct_m2 = 0.0;  ///< of these, covered with the label
  double false_m2 = 0.0;    ///< result cells with the label that lie on nothing that excuses them
  double iou() const {
    const double all_m2 = true_m2 + false_m2;
    return all_m2 > 0.0 ? correct_m2 / all_m2 : 0.0;
  }
};

struct MapEvaluation {
  Eigen::Isometry3d T_true_result = Eigen::Isometry3d::Identity();
  double true_m2 = 0.0;    ///< of true cells
  double result_m2 = 0.0;  ///< of result cells
  double coverage = 0.0;
  double ghost_area = 0.0;  ///< share of result_m2
  double support_plane_rms_m = 0.0;
  double plane_rms_m = 0.0;
  double plane_p95_m = 0.0;
  double normal_mean_deg = 0.0;
  double normal_p95_deg = 0.0;
  EdgeFigures edges;
  double over_segmentation = 0.0;   ///< regions per true polygon found; 1 is perfect
  double under_segmentation = 0.0;  ///< true polygons per region that covers something; 1 is perfect
  double label_accuracy = 0.0;      ///< share of covered area with the right label
  std::map<std::string, LabelEvaluation> labels;
  /// Area by true label, then by label of the result or "missed"; the row "ghost" is what lies near no truth.
  std::map<std::string, std::map<std::string, double>> confusion_m2;
  std::vector<PolygonEvaluation> polygons;

  /// Mean IoU of the labels that the truth has.
  double mean_iou() const;
};

/// @param T_true_result  what moves the map onto the truth, from AlignByOrientations.
/// Throws std::runtime_error when a region is too large to be true.
MapEvaluation EvaluateMap(const TerrainMap& map, const TrueScene& truth,
                          const Eigen::Isometry3d& T_true_result, const MapEvaluationOptions& options = {});

}  // namespace terrace
