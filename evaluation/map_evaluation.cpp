// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/map_evaluation.h"

#include <algorithm>
#include <cmath>

#include "evaluation/covered_cells.h"
#include "evaluation/edge_errors.h"
#include "evaluation/statistics.h"

namespace terrace {
namespace {

constexpr double kRadPerDeg = EIGEN_PI / 180.0;
constexpr double kResultCell_m = 0.04;
/// A result cell lies on a true polygon within these; wider, so that nothing is both missed and false.
constexpr double kNearDistance_m = 0.075;
constexpr double kNearAngle_rad = 22.5 * kRadPerDeg;
/// Planes one can stand on, by |normal z|.
constexpr double kSupportNormalZ = 0.7;
/// A region, or a polygon, counts as a piece of the other from this share of the common cells.
constexpr double kPieceShare = 0.1;

/// What accumulates over all true polygons.
struct Tally {
  std::vector<double> distances_m;
  std::vector<double> support_distances_m;
  std::vector<double> angles_deg;
  EdgeErrors edges;
  /// Covered cells by region, then by true polygon.
  std::map<int, std::map<int, int>> cells_of_region;
};

void EvaluateCells(const TrueShape& truth, const CoveredCells& cells, const std::vector<MapRegion>& regions,
                   PolygonEvaluation* polygon, MapEvaluation* evaluation, Tally* tally) {
  const double cell_m2 = truth.polygon->observed.cell_m * truth.polygon->observed.cell_m;
  const bool support = std::abs(truth.shape.plane().normal.z()) > kSupportNormalZ;
  LabelEvaluation& label = evaluation->labels[polygon->label];
  std::map<std::string, double>& confusion_m2 = evaluation->confusion_m2[polygon->label];
  std::map<std::string, int> cells_of_label;
  std::vector<double> heights_m, angles_deg;
  cells.ForEach([&](const Eigen::Vector3d& centre, int k) {
    polygon->seen_m2 += cell_m2;
    label.true_m2 += cell_m2;
    if (k == kNoRegion) {
      confusion_m2["missed"] += cell_m2;
      return;
    }
    const MapRegion& region = regions[static_cast<std::size_t>(k)];
    polygon->covered_m2 += cell_m2;
    confusion_m2[region.label] += cell_m2;
    ++cells_of_label[region.label];
    if (region.label == polygon->label) {
      polygon->correct_m2 += cell_m2;
      label.correct_m2 += cell_m2;
    }
    const double side = region.shape.plane().normal.dot(truth.shape.plane().normal) < 0.0 ? -1.0 : 1.0;
    heights_m.push_back(-side * region.shape.plane().SignedDistance(centre));
    angles_deg.push_back(region.shape.AngleTo(truth.shape.plane()) / kRadPerDeg);
    ++tally->cells_of_region[k][polygon->id];
  });
  polygon->plane_rms_m = RmsOf(heights_m);
  polygon->plane_bias_m = MeanOf(heights_m);
  polygon->normal_deg = MeanOf(angles_deg);
  int most = 0;
  for (const auto& [name, count] : cells_of_label) {
    if (count > most) polygon->label_found = name;
    most = std::max(most, count);
  }
  for (double height_m : heights_m) {
    tally->distances_m.push_back(std::abs(height_m));
    if (support) tally->support_distances_m.push_back(height_m);
  }
  tally->angles_deg.insert(tally->angles_deg.end(), angles_deg.begin(), angles_deg.end());
}

/// How many of the counts reach a tenth of their sum.
int NumPieces(const std::map<int, int>& counts) {
  int sum = 0;
  for (const auto& [id, count] : counts) sum += count;
  return static_cast<int>(std::count_if(
      counts.begin(), counts.end(), [&](const auto& entry) { return entry.second >= kPieceShare * sum; }));
}

void EvaluateSegmentation(const Tally& tally, MapEvaluation* evaluation) {
  std::map<int, std::map<int, int>> cells_of_polygon;
  std::vector<double> pieces;
  for (const auto& [region, cells] : tally.cells_of_region) {
    pieces.push_back(NumPieces(cells));
    for (const auto& [polygon, count] : cells) cells_of_polygon[polygon][region] += count;
  }
  evaluation->under_segmentation = MeanOf(pieces);
  pieces.clear();
  for (PolygonEvaluation& polygon : evaluation->polygons) {
    const auto cells = cells_of_polygon.find(polygon.id);
    if (cells == cells_of_polygon.end()) continue;
    polygon.num_regions = NumPieces(cells->second);
    pieces.push_back(polygon.num_regions);
  }
  evaluation->over_segmentation = MeanOf(pieces);
}

/// What of the result lies where there is nothing, and what carries a label that nothing true there has.
void EvaluateResultCells(const std::vector<MapRegion>& regions, const std::vector<TrueShape>& truths,
                         MapEvaluation* evaluation) {
  constexpr double kCell_m2 = kResultCell_m * kResultCell_m;
  double ghost_m2 = 0.0;
  for (const MapRegion& region : regions) {
    std::vector<bool> parallel;
    for (const TrueShape& truth : truths) {
      parallel.push_back(truth.shape.AngleTo(region.shape.plane()) <= kNearAngle_rad);
    }
    double false_m2 = 0.0;
    region.shape.ForEachCell(kResultCell_m, [&](const Eigen::Vector3d& centre) {
      bool near_any = false;
      bool excused = false;
      for (std::size_t k = 0; k < truths.size(); ++k) {
        const TrueShape& truth = truths[k];
        if (std::abs(truth.shape.plane().SignedDistance(centre)) > kNearDistance_m) continue;
        if (!truth.shape.LiesOver(centre)) continue;
        near_any = true;
        if (parallel[k] && (!truth.asked || truth.polygon->label == region.label)) excused = true;
      }
      evaluation->result_m2 += kCell_m2;
      if (!near_any) {
        ghost_m2 += kCell_m2;
        evaluation->confusion_m2["ghost"][region.label] += kCell_m2;
      }
      if (!excused) false_m2 += kCell_m2;
    });
    evaluation->labels[region.label].false_m2 += false_m2;
  }
  if (evaluation->result_m2 > 0.0) evaluation->ghost_area = ghost_m2 / evaluation->result_m2;
}

}  // namespace

double MapEvaluation::mean_iou() const {
  std::vector<double> ious;
  for (const auto& [name, label] : labels) {
    if (label.true_m2 > 0.0) ious.push_back(label.iou());
  }
  return MeanOf(ious);
}

MapEvaluation EvaluateMap(const TerrainMap& map, const TrueScene& truth,
                          const Eigen::Isometry3d& T_true_result, const MapEvaluationOptions& options) {
  MapEvaluation evaluation;
  evaluation.T_true_result = T_true_result;
  const std::vector<MapRegion> regions = MoveRegions(map, T_true_result);
  const std::vector<TrueShape> truths = ShapesOf(truth, options);
  Tally tally;
  double covered_m2 = 0.0, correct_m2 = 0.0;
  for (const TrueShape& shape : truths) {
    if (!shape.asked) continue;
    PolygonEvaluation polygon;
    polygon.id = shape.polygon->id;
    polygon.name = shape.polygon->name;
    polygon.label = shape.polygon->label;
    const CoveredCells cells(shape.shape, shape.polygon->observed, regions);
    EvaluateCells(shape, cells, regions, &polygon, &evaluation, &tally);
    if (polygon.seen_m2 == 0.0) continue;
    EdgeErrors edges;
    edges.Add(shape, cells, regions);
    polygon.edges = edges.Figures();
    tally.edges.Append(edges);
    evaluation.true_m2 += polygon.seen_m2;
    covered_m2 += polygon.covered_m2;
    correct_m2 += polygon.correct_m2;
    evaluation.polygons.push_back(polygon);
  }
  EvaluateSegmentation(tally, &evaluation);
  EvaluateResultCells(regions, truths, &evaluation);
  if (evaluation.true_m2 > 0.0) evaluation.coverage = covered_m2 / evaluation.true_m2;
  if (covered_m2 > 0.0) evaluation.label_accuracy = correct_m2 / covered_m2;
  evaluation.support_plane_rms_m = RmsOf(tally.support_distances_m);
  evaluation.plane_rms_m = RmsOf(tally.distances_m);
  evaluation.plane_p95_m = QuantileOf(tally.distances_m, 0.95);
  evaluation.normal_mean_deg = MeanOf(tally.angles_deg);
  evaluation.normal_p95_deg = QuantileOf(tally.angles_deg, 0.95);
  evaluation.edges = tally.edges.Figures();
  return evaluation;
}

}  // namespace terrace
