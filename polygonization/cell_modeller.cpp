// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/cell_modeller.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/check.h"
#include "core/field_problems.h"
#include "core/parallel_for.h"
#include "polygonization/cell_fit.h"

namespace terrace {
namespace {

std::uint64_t SeedOf(const CellKey& key) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(key.x)) << 42) ^
         (static_cast<std::uint64_t>(static_cast<std::uint32_t>(key.y)) << 21) ^
         static_cast<std::uint64_t>(static_cast<std::uint32_t>(key.z));
}

}  // namespace

std::vector<std::string> ModellingConfig::Problems() const {
  FieldProblems problems;
  problems.RequireAbove("inlier_distance_m", inlier_distance_m, 0.0);
  problems.Require(max_inlier_distance_m >= inlier_distance_m, "max_inlier_distance_m", max_inlier_distance_m,
                   "be at least inlier_distance_m");
  problems.RequireUpTo("max_rms_share", max_rms_share, 0.0, 1.0);
  problems.RequireAtLeast("min_patch_area_m2", min_patch_area_m2, 0.0);
  problems.RequireWithin("max_planes", max_planes, 1, 100);
  problems.RequireWithin("num_hypotheses", num_hypotheses, 1, 10000);
  problems.RequireAtLeast("num_pretest", num_pretest, 3);
  return problems.Take();
}

CellModeller::CellModeller(const ModellingConfig& config) : config_(config) {
  TERRACE_CHECK(config.Problems().empty());
}

/// Planes of the cell itself first, then those of its neighbours that pass through it, each direction once.
std::vector<Plane> CellModeller::HintsFor(const CellKey& key, const Eigen::Vector3d& centre_world,
                                          double cell_size_m) const {
  const double kSameCosine = std::cos(0.05);
  constexpr double kSameOffset_m = 0.005;
  std::vector<Plane> hints;
  const auto add_from = [&](const CellKey& from) {
    const auto found = planes_world_.find(from);
    if (found == planes_world_.end()) return;
    for (const Plane& plane : found->second) {
      const double offset = plane.SignedDistance(centre_world);
      if (std::abs(offset) > 0.5 * cell_size_m * plane.normal.cwiseAbs().sum()) continue;
      const bool known = std::any_of(hints.begin(), hints.end(), [&](const Plane& other) {
        return plane.normal.dot(other.normal) > kSameCosine &&
               std::abs(offset - other.SignedDistance(centre_world)) < kSameOffset_m;
      });
      if (!known) hints.push_back(plane);
    }
  };
  add_from(key);
  for (int dx = -1; dx <= 1; ++dx)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dz = -1; dz <= 1; ++dz)
        if (dx != 0 || dy != 0 || dz != 0) add_from({key.x + dx, key.y + dy, key.z + dz});
  return hints;
}

PatchUpdate CellModeller::Fit(const TerrainOctree& octree, const ChangedCells& cells) {
  PatchUpdate update{cells.frame_id, cells.t_capture, {}};
  update.cells.resize(cells.keys.size());
  ParallelForPieces(cells.keys.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<Surfel> surfels;
    for (std::size_t i = begin; i < end; ++i) {
      PatchUpdate::CellPatches& cell = update.cells[i];
      cell.key = cells.keys[i];
      cell.centre_world = octree.CellCentre(cell.key);
      octree.CollectSurfels(cell.key, &surfels);
      std::vector<CellPlane> hints;
      for (const Plane& plane : HintsFor(cell.key, cell.centre_world, octree.cell_size_m()))
        hints.push_back(
            {plane.normal.cast<float>(), static_cast<float>(-plane.SignedDistance(cell.centre_world))});
      cell.patches =
          CellFit(config_, surfels, octree.cell_size_m(), std::move(hints), SeedOf(cell.key)).Run();
      for (Patch& patch : cell.patches)
        patch.plane_world.offset_m += patch.plane_world.normal.dot(cell.centre_world);
    }
  });
  for (const PatchUpdate::CellPatches& cell : update.cells) {
    if (cell.patches.empty()) {
      planes_world_.erase(cell.key);
      continue;
    }
    std::vector<Plane>& planes = planes_world_[cell.key];
    planes.clear();
    for (const Patch& patch : cell.patches) planes.push_back(patch.plane_world);
  }
  return update;
}

}  // namespace terrace
