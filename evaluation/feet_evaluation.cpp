// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/feet_evaluation.h"

#include <algorithm>
#include <cmath>

#include "evaluation/covered_cells.h"
#include "evaluation/map_shapes.h"

namespace terrace {
namespace {

constexpr double kFootCell_m = 0.01;
constexpr double kFootCell_m2 = kFootCell_m * kFootCell_m;
/// A foot is set this far inside an outline.
constexpr double kFootInside_m = 0.03;
constexpr double kFootDisc_m = 0.02;
constexpr double kFootHeight_m = 0.025;
/// A missing foothold is worst here.
constexpr double kNearDrop_m = 0.1;
/// Treads of which less was well seen say nothing.
constexpr double kTreadSeen_m2 = 0.01;
/// An outline and a drop belong together when their heights agree this well.
constexpr double kDropHeight_m = 0.05;
constexpr double kReachStep_m = 0.001;
constexpr double kLongestReach_m = 0.5;

std::vector<MapRegion> WalkableOnly(std::vector<MapRegion> regions) {
  std::erase_if(regions, [](const MapRegion& region) { return !IsWalkable(region.label); });
  return regions;
}

/// At least 3 cm inside the outline and outside the holes?
bool IsFoothold(const PlanarShape& shape, const Eigen::Vector3d& p) {
  return shape.LiesOver(p) && shape.DistanceToEdge(p) >= kFootInside_m;
}

/// Distances along z of walkable planes differ from those along their normals.
double HeightAbove(const Plane& plane, const Eigen::Vector3d& p) {
  return plane.SignedDistance(p) / plane.normal.z();
}

bool NearDrop(const Eigen::Vector3d& p, const std::vector<DropSample>& drops) {
  return std::any_of(drops.begin(), drops.end(),
                     [&](const DropSample& drop) { return (p - drop.p).head<2>().norm() <= kNearDrop_m; });
}

void EvaluateFootholds(const std::vector<MapRegion>& regions, const TrueGround& ground,
                       FeetEvaluation* feet) {
  std::vector<FootCell> unsupported;
  for (const MapRegion& region : regions) {
    region.shape.ForEachCell(kFootCell_m, [&](const Eigen::Vector3d& p) {
      if (region.shape.DistanceToEdge(p) < kFootInside_m) return;
      feet->foothold_m2 += kFootCell_m2;
      if (ground.Carries(p, kFootDisc_m, kFootHeight_m)) {
        feet->cells.push_back({p.head<2>(), FootCell::Kind::kOffered});
        return;
      }
      unsupported.push_back({p.head<2>(), FootCell::Kind::kUnsupported});
      feet->unsupported_m2 += kFootCell_m2;
      if (region.region->label == TerrainLabel::kStairTread) feet->unsupported_tread_m2 += kFootCell_m2;
      if (NearDrop(p, feet->drops)) feet->unsupported_drop_m2 += kFootCell_m2;
    });
  }
  // Last, so that nothing hides them.
  feet->cells.insert(feet->cells.end(), unsupported.begin(), unsupported.end());
}

bool IsOffered(const std::vector<MapRegion>& regions, const Eigen::Vector3d& p) {
  return std::any_of(regions.begin(), regions.end(), [&](const MapRegion& region) {
    return std::abs(HeightAbove(region.shape.plane(), p)) <= kFootHeight_m && IsFoothold(region.shape, p);
  });
}

/// Calls use(middle) for each square centimetre of the cells that are marked.
template <typename Use>
void ForEachFootCell(const ObservedCells& cells, const Plane& plane, Use use) {
  const int parts = std::max(1, static_cast<int>(std::lround(cells.cell_m / kFootCell_m)));
  ObservedCells fine = cells;
  fine.cell_m = cells.cell_m / parts;
  for (int i = 0; i < cells.nx * parts; ++i) {
    for (int j = 0; j < cells.ny * parts; ++j) {
      const int coarse = i / parts * cells.ny + j / parts;
      if (cells.seen[static_cast<std::size_t>(coarse)]) use(fine.Centre(i, j, plane));
    }
  }
}

void EvaluateTruth(const TrueShape& truth, const ObservedCells& well_seen,
                   const std::vector<MapRegion>& regions, FeetEvaluation* feet) {
  TreadFeet here{truth.polygon->id, truth.polygon->name};
  ForEachFootCell(well_seen, truth.shape.plane(), [&](const Eigen::Vector3d& p) {
    if (!IsFoothold(truth.shape, p)) return;
    here.well_seen_m2 += kFootCell_m2;
    if (IsOffered(regions, p)) {
      here.offered_m2 += kFootCell_m2;
    } else {
      feet->cells.push_back({p.head<2>(), FootCell::Kind::kMissed});
    }
  });
  feet->well_seen_m2 += here.well_seen_m2;
  feet->offered_m2 += here.offered_m2;
  if (truth.polygon->label == Name(TerrainLabel::kStairTread) && here.well_seen_m2 >= kTreadSeen_m2)
    feet->treads.push_back(here);
}

/// How far outlines go on past a drop without a true surface below them.
double ReachPast(const DropSample& drop, const std::vector<MapRegion>& regions, const TrueGround& ground) {
  double reach_m = 0.0;
  for (const MapRegion& region : regions) {
    if (std::abs(HeightAbove(region.shape.plane(), drop.p)) > kDropHeight_m) continue;
    for (int step = 1; step * kReachStep_m <= kLongestReach_m; ++step) {
      const Eigen::Vector3d p = drop.p + step * kReachStep_m * drop.outwards;
      if (!region.shape.LiesOver(p) || ground.Carries(p, 0.0, kFootHeight_m)) break;
      reach_m = std::max(reach_m, step * kReachStep_m);
    }
  }
  return reach_m;
}

std::optional<double> Percent(double part, double whole) {
  return whole > 0.0 ? std::optional(100.0 * part / whole) : std::nullopt;
}

}  // namespace

std::optional<double> FeetEvaluation::unsupported_pct() const { return Percent(unsupported_m2, foothold_m2); }
std::optional<double> FeetEvaluation::offered_pct() const { return Percent(offered_m2, well_seen_m2); }

std::optional<double> FeetEvaluation::tread_offered_pct() const {
  if (treads.empty()) return std::nullopt;
  double sum = 0.0;
  for (const TreadFeet& tread : treads) sum += tread.offered_pct();
  return sum / static_cast<double>(treads.size());
}

std::optional<double> FeetEvaluation::tread_offered_min_pct() const {
  if (treads.empty()) return std::nullopt;
  double least = 100.0;
  for (const TreadFeet& tread : treads) least = std::min(least, tread.offered_pct());
  return least;
}

FeetEvaluation EvaluateFeet(const TerrainMap& map, const TrueScene& truth, const CellsOfPolygons& well_seen,
                            const Eigen::Isometry3d& T_true_result) {
  FeetEvaluation feet;
  const TrueGround ground(truth);
  const std::vector<MapRegion> regions = MoveRegions(map, T_true_result);
  const std::vector<MapRegion> walkable = WalkableOnly(regions);
  feet.drops = ground.Drops();
  feet.num_drop_samples = static_cast<int>(feet.drops.size());
  EdgeErrors edges;
  for (const TrueShape& shape : ShapesOf(truth, {})) {
    const auto cells = well_seen.find(shape.polygon->id);
    if (cells == well_seen.end()) continue;
    EvaluateTruth(shape, cells->second, walkable, &feet);
    edges.Add(shape, CoveredCells(shape.shape, cells->second, regions), regions);
  }
  feet.edges = edges.Figures();
  EvaluateFootholds(walkable, ground, &feet);
  for (const DropSample& drop : feet.drops) {
    feet.drop_over_p100_m = std::max(feet.drop_over_p100_m.value_or(0.0), ReachPast(drop, walkable, ground));
  }
  return feet;
}

}  // namespace terrace
