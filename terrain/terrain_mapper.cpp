// SPDX-License-Identifier: BSD-3-Clause
#include "terrain/terrain_mapper.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "stereo/cloud.h"

namespace terrace {
namespace {

/// How far away points are still certain enough to be mapped, where disparities are as good as they ever get.
double FarthestMapped(const StereoCamera& camera, const CloudConfig& cloud) {
  constexpr double kFinestSigma_px = 0.05;
  return std::sqrt(cloud.max_depth_sigma_m * camera.fx * camera.baseline_m / kFinestSigma_px);
}

MapReach ReachOf(const MappingConfig& mapping, double window_m) {
  MapReach reach;
  reach.window_m = window_m;
  if (mapping.keep_beyond_m > 0.0) reach.keep_beyond_m = std::max(window_m, mapping.keep_beyond_m);
  reach.cell_size_m = mapping.cell_size_m();
  return reach;
}

}  // namespace

TerrainMapper::Parts::Parts(const TerrainConfig& config, const StereoCamera& camera,
                            const std::optional<Eigen::Isometry3d>& T_body_left, double window_m,
                            std::int64_t map_id)
    : octree(config.mapping),
      modeller(config.modelling),
      merger(config.merging, ReachOf(config.mapping, window_m)),
      labeler(config.labeling, config.staircases, config.robot, camera, T_body_left, map_id) {}

TerrainMapper::TerrainMapper(const TerrainConfig& config, const StereoCamera& camera,
                             const std::optional<Eigen::Isometry3d>& T_body_left, StageMeters* meters)
    : config_(config),
      camera_(camera),
      T_body_left_(T_body_left),
      window_m_(std::max(config.mapping.window_m, FarthestMapped(camera, config.cloud))),
      meters_(meters) {
  parts_.emplace(config_, camera_, T_body_left_, window_m_, 1);
}

MapChange TerrainMapper::Update(const DepthView& view, const PoseEstimate& pose, const Gravity& gravity) {
  TERRACE_CHECK(pose.trusted, pose.reason);
  const PolygonUpdate polygons =
      parts_->resting.ShowsNothingNew(view.disparity, pose.T_world_left)
          ? parts_->merger.SeeNothingNew(view.disparity.frame_id, view.disparity.t_capture)
          : AddEvidence(view, pose);
  StageMeasurement measuring(meters_, StageId::kLabels);
  MapChange change = parts_->labeler.Label(polygons, pose, gravity);

  FoldFarFrom(pose.T_world_left.translation());
  parts_->level_planes.Update(polygons);
  gravity_hint_ = parts_->level_planes.Hint(gravity);
  CountCells(&change);
  return change;
}

PolygonUpdate TerrainMapper::AddEvidence(const DepthView& view, const PoseEstimate& pose) {
  StageMeasurement measuring(meters_, StageId::kDecomposition);
  const Cloud cloud = Triangulate(view.disparity, view.camera, config_.cloud, view.self_mask);
  const ChangedCells cells = parts_->octree.Insert(cloud, view.camera, pose);
  measuring.Next(StageId::kModelling);
  const PatchUpdate patches = parts_->modeller.Fit(parts_->octree, cells);
  measuring.Next(StageId::kMerging);
  return parts_->merger.Merge(patches, {view.camera, pose.T_world_left, &view.disparity});
}

void TerrainMapper::FoldFarFrom(const Eigen::Vector3d& p_world) {
  const std::vector<CellKey> gone = parts_->octree.ForgetBeyond(p_world, window_m_);
  parts_->modeller.Forget(gone);
  parts_->merger.Fold(gone);
}

MapChange TerrainMapper::Unchanged() const {
  MapChange change;
  change.before = change.map = map();
  CountCells(&change);
  return change;
}

void TerrainMapper::Reset() {
  const std::int64_t map_id = map()->map_id + 1;
  parts_.emplace(config_, camera_, T_body_left_, window_m_, map_id);
  gravity_hint_.reset();
}

void TerrainMapper::CountCells(MapChange* change) const {
  change->map_cells = parts_->octree.num_occupied_leaves();
  change->map_bytes = parts_->octree.memory_bytes() + parts_->merger.memory_bytes();
}

}  // namespace terrace
