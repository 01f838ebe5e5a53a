// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/map_evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/check.h"
#include "evaluation/planar_shape.h"
#include "evaluation/statistics.h"

namespace terrace {
namespace {

constexpr double kRadPerDeg = EIGEN_PI / 180.0;
constexpr double kResultCell_m = 0.04;
/// A region covers a true cell within these.
constexpr double kCoverDistance_m = 0.05;
constexpr double kCoverAngle_rad = 15.0 * kRadPerDeg;
/// A result cell lies on a true polygon within these; wider, so that nothing is both missed and false.
constexpr double kNearDistance_m = 0.075;
constexpr double kNearAngle_rad = 22.5 * kRadPerDeg;
/// Planes one can stand on, by |normal z|.
constexpr double kSupportNormalZ = 0.7;
/// A region, or a polygon, counts as a piece of the other from this share of the common cells.
constexpr double kPieceShare = 0.1;
constexpr double kEdgeStep_m = 0.02;
/// Beyond this an edge is not displaced but absent.
constexpr double kMaxEdgeError_m = 0.2;
/// About 160,000 m^2 in cells: no map of a walking robot.
constexpr double kMaxRegionCells = 1e8;
constexpr int kNoRegion = -1;

/// One region of the result, moved onto the truth.
struct MapRegion {
  const TerrainRegion* region;
  PlanarShape shape;
  std::string label;
};

struct TrueShape {
  const TruePolygon* polygon;
  PlanarShape shape;
  bool asked;  ///< its cells count
};

std::string ComparedLabel(TerrainLabel label) {
  return Name(label == TerrainLabel::kLevel ? TerrainLabel::kObstacle : label);
}

std::vector<MapRegion> MoveRegions(const TerrainMap& map, const Eigen::Isometry3d& T_true_result) {
  std::vector<MapRegion> regions;
  for (const auto& region : map.regions) {
    std::vector<Ring> holes;
    for (const Ring& hole : region->holes_world) holes.push_back(Moved(T_true_result, hole));
    regions.push_back({region.get(),
                       PlanarShape(Moved(T_true_result, region->plane_world),
                                   Moved(T_true_result, region->outline_world), holes),
                       ComparedLabel(region->label)});
    if (regions.back().shape.BoxArea() / (kResultCell_m * kResultCell_m) > kMaxRegionCells) {
      throw std::runtime_error("region " + std::to_string(region->id) + " is too large to be true");
    }
  }
  return regions;
}

std::vector<TrueShape> ShapesOf(const TrueScene& truth, const MapEvaluationOptions& options) {
  std::vector<TrueShape> shapes;
  for (const TruePolygon& polygon : truth.polygons) {
    const bool asked =
        (options.include_other || polygon.label != "other") && (options.include_detail || !polygon.detail);
    shapes.push_back(
        {&polygon, PlanarShape(polygon.plane_world, polygon.outline_world, polygon.holes_world), asked});
  }
  return shapes;
}

/// Which region covers each cell of one true polygon.
class CoveredCells {
 public:
  CoveredCells(const TrueShape& truth, const std::vector<MapRegion>& regions)
      : cells_(truth.polygon->observed), shape_(truth.shape), taken_(cells_.seen.size(), kNotAsked) {
    std::vector<int> candidates;
    for (std::size_t k = 0; k < regions.size(); ++k) {
      if (regions[k].shape.AngleTo(shape_.plane()) <= kCoverAngle_rad) {
        candidates.push_back(static_cast<int>(k));
      }
    }
    for (int i = 0; i < cells_.nx; ++i) {
      for (int j = 0; j < cells_.ny; ++j) {
        const Eigen::Vector3d centre = cells_.Centre(i, j, shape_.plane());
        if (!cells_.seen[Index(i, j)] || !shape_.LiesOver(centre)) continue;
        taken_[Index(i, j)] = NearestOver(centre, candidates, regions);
      }
    }
  }

  /// Calls use(centre, region index or kNoRegion) for every cell that counts.
  template <typename Use>
  void ForEach(Use use) const {
    for (int i = 0; i < cells_.nx; ++i) {
      for (int j = 0; j < cells_.ny; ++j) {
        const int region = taken_[Index(i, j)];
        if (region != kNotAsked) use(cells_.Centre(i, j, shape_.plane()), region);
      }
    }
  }

  /// The region over the cell that holds this point of the plane; kNoRegion when there is none or the cell
  /// does not count.
  int RegionAt(const Eigen::Vector3d& p) const {
    const double i = std::floor((cells_.axis_x.dot(p) - cells_.origin_m.x()) / cells_.cell_m);
    const double j = std::floor((cells_.axis_y.dot(p) - cells_.origin_m.y()) / cells_.cell_m);
    if (!(i >= 0 && i < cells_.nx && j >= 0 && j < cells_.ny)) return kNoRegion;
    return std::max(taken_[Index(static_cast<int>(i), static_cast<int>(j))], kNoRegion);
  }

 private:
  static constexpr int kNotAsked = -2;

  std::size_t Index(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(cells_.ny) + static_cast<std::size_t>(j);
  }

  static int NearestOver(const Eigen::Vector3d& centre, const std::vector<int>& candidates,
                         const std::vector<MapRegion>& regions) {
    int nearest = kNoRegion;
    double least_m = std::numeric_limits<double>::infinity();
    for (int k : candidates) {
      const PlanarShape& shape = regions[static_cast<std::size_t>(k)].shape;
      const double distance_m = std::abs(shape.plane().SignedDistance(centre));
      if (distance_m > kCoverDistance_m || distance_m >= least_m || !shape.LiesOver(centre)) continue;
      nearest = k;
      least_m = distance_m;
    }
    return nearest;
  }

  const ObservedCells& cells_;
  const PlanarShape& shape_;
  std::vector<int> taken_;
};

/// What accumulates over all true polygons.
struct Tally {
  std::vector<double> distances_m;
  std::vector<double> support_distances_m;
  std::vector<double> angles_deg;
  std::vector<double> edge_errors_m;
  std::vector<double> signed_edge_errors_m;
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

/// Samples the true edges where the cell just inside is covered, and asks how far the edge of the region that
/// covers it is.
void EvaluateEdges(const TrueShape& truth, const CoveredCells& cells, const std::vector<MapRegion>& regions,
                   PolygonEvaluation* polygon, Tally* tally) {
  std::vector<double> errors_m;
  const auto sample_ring = [&](const Ring& ring) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const Eigen::Vector3d edge = ring[i] - ring[j];
      const int steps = static_cast<int>(edge.norm() / kEdgeStep_m);
      if (steps == 0) continue;
      Eigen::Vector3d inwards = truth.shape.plane().normal.cross(edge).normalized() * kEdgeStep_m;
      if (!truth.shape.LiesOver(ring[j] + 0.5 * edge + inwards)) inwards = -inwards;
      for (int step = 0; step < steps; ++step) {
        const Eigen::Vector3d p = ring[j] + (step + 0.5) / steps * edge;
        const int k = cells.RegionAt(p + inwards);
        if (k == kNoRegion) continue;
        const PlanarShape& shape = regions[static_cast<std::size_t>(k)].shape;
        const double error_m = std::min(shape.DistanceToEdge(p), kMaxEdgeError_m);
        errors_m.push_back(error_m);
        tally->signed_edge_errors_m.push_back(shape.LiesOver(p) ? error_m : -error_m);
      }
    }
  };
  sample_ring(truth.polygon->outline_world);
  for (const Ring& hole : truth.polygon->holes_world) sample_ring(hole);
  polygon->num_edge_samples = static_cast<int>(errors_m.size());
  polygon->edge_median_m = QuantileOf(errors_m, 0.5);
  tally->edge_errors_m.insert(tally->edge_errors_m.end(), errors_m.begin(), errors_m.end());
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
    const CoveredCells cells(shape, regions);
    EvaluateCells(shape, cells, regions, &polygon, &evaluation, &tally);
    if (polygon.seen_m2 == 0.0) continue;
    EvaluateEdges(shape, cells, regions, &polygon, &tally);
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
  evaluation.edge_median_m = QuantileOf(tally.edge_errors_m, 0.5);
  evaluation.edge_p95_m = QuantileOf(tally.edge_errors_m, 0.95);
  evaluation.edge_bias_m = MeanOf(tally.signed_edge_errors_m);
  evaluation.num_edge_samples = static_cast<int>(tally.edge_errors_m.size());
  return evaluation;
}

}  // namespace terrace
