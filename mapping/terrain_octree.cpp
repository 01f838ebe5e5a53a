// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/terrain_octree.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "mapping/change_report.h"
#include "mapping/frame_leaves.h"
#include "mapping/free_space.h"
#include "mapping/leaf_tree.h"
#include "mapping/point_summing.h"
#include "mapping/view_tiles.h"

namespace terrace {
namespace {

constexpr int kFramesToReplace = 3;  // that a fine leaf is known by before coarse ones give way
constexpr int kTidyTurns = 32;       // frames in which every cell is looked through once
constexpr int kForgottenBlocks = 4;  // a frame, at most; a walking robot leaves less than one behind

Surfel SurfelOf(const Leaf& leaf, const Evidence& evidence, const MappingConfig& config) {
  const float leaf_m = static_cast<float>(config.leaf_size_m);
  const auto size = static_cast<float>(1 << evidence.level);
  const Eigen::Vector3f in_cell(evidence.corner[0], evidence.corner[1], evidence.corner[2]);
  const Eigen::Vector3f centre =
      leaf_m *
      (in_cell + Eigen::Vector3f::Constant(0.5F * (size - static_cast<float>(config.leaves_per_cell))));
  Surfel surfel;
  surfel.size_m = size * leaf_m;
  surfel.mean = centre + leaf.Mean_m(surfel.size_m);
  surfel.covariance = leaf.Covariance_m2(surfel.size_m);
  surfel.view = leaf.View();
  // Points are weighted by 1 / variance, so count over weight is their mean variance.
  surfel.sigma_view_m = std::sqrt(leaf.num_points() / leaf.weight);
  surfel.num_points = leaf.num_points();
  surfel.num_frames = evidence.num_frames;
  surfel.spacing_m = static_cast<float>(leaf.spacing_m);
  return surfel;
}

}  // namespace

class TerrainOctree::Impl {
 public:
  explicit Impl(const MappingConfig& config)
      : config_(config), tree_(config), report_(config.memory_frames) {}

  ChangedCells Insert(const Cloud& cloud, const StereoCamera& camera, const PoseEstimate& pose) {
    if (!pose.trusted || !IsCountable(pose.T_world_left.translation(), config_))
      return {cloud.frame_id, cloud.t_capture, {}};
    report_.Begin(cloud.frame_id);
    SumPoints(cloud, camera, pose.T_world_left, config_, &frame_leaves_, &tiles_);
    AddToTree(cloud.frame_id, camera, pose.T_world_left.translation());
    tiles_.Widen();
    FreeSpace free(config_, camera, pose.T_world_left, cloud.frame_id, tiles_);
    free.Check(&tree_, [this](Cell* cell) { report_.Touch(cell); });
    DropOldNoise(cloud.frame_id);
    return {cloud.frame_id, cloud.t_capture, report_.Take(&tree_)};
  }

  std::vector<CellKey> ForgetBeyond(const Eigen::Vector3d& p_world, double radius_m) {
    if (!IsCountable(p_world, config_)) return {};
    const int radius_leaves = static_cast<int>(std::ceil(radius_m / config_.leaf_size_m));
    std::vector<CellKey> gone = tree_.ForgetBeyond(LeafAt(p_world, config_), radius_leaves, kForgottenBlocks);
    for (const CellKey& key : gone) report_.Forget(key);
    return gone;
  }

  void CollectSurfels(const CellKey& cell, std::vector<Surfel>* surfels) const {
    surfels->clear();
    const int slot = tree_.FindCell(cell);
    if (slot == kNothing) return;
    tree_.leaves().ForEach(tree_.cell(slot).leaves, [&](int index) {
      const Evidence& evidence = tree_.leaves().evidence(index);
      if (evidence.occupied) surfels->push_back(SurfelOf(tree_.leaves().leaf(index), evidence, config_));
    });
  }

  std::vector<OccupiedLeaf> LeavesIn(const Eigen::AlignedBox3d& box_world) {
    std::vector<OccupiedLeaf> found;
    if (!IsCountable(box_world.min(), config_) || !IsCountable(box_world.max(), config_)) return found;
    const LeafIndex lowest = LeafAt(box_world.min(), config_), highest = LeafAt(box_world.max(), config_);
    const auto reaches_in = [&](const LeafIndex& corner, int size) {
      return (corner.array() <= highest.array()).all() && (corner.array() + size > lowest.array()).all();
    };
    tree_.ForEachCell((lowest + highest) / 2, reaches_in, [&](int slot, const LeafIndex& cell_corner) {
      for (const int index : tree_.cell(slot).leaves) {
        const Evidence& evidence = tree_.leaves().evidence(index);
        const LeafIndex corner =
            cell_corner + LeafIndex(evidence.corner[0], evidence.corner[1], evidence.corner[2]);
        if (evidence.occupied && reaches_in(corner, 1 << evidence.level))
          found.push_back({corner, evidence.level, std::max<int>(1, evidence.credit)});
      }
    });
    return found;
  }

  const LeafPool& leaves() const { return tree_.leaves(); }
  std::int64_t memory_bytes() const { return tree_.memory_bytes() + frame_leaves_.memory_bytes(); }

 private:
  void AddToTree(FrameId frame_id, const StereoCamera& camera, const Eigen::Vector3d& camera_world) {
    constexpr std::size_t kAhead = 8;  // leaves that memory has time for while others are added to
    const LeafIndex camera_leaf = LeafAt(camera_world, config_);
    const std::vector<FrameLeaf>& frame_leaves = frame_leaves_.leaves();
    for (std::size_t i = 0; i < frame_leaves.size(); ++i) {
      if (i + kAhead < frame_leaves.size() && frame_leaves[i + kAhead].place.leaf != kNothing)
        tree_.leaves().Prefetch(frame_leaves[i + kAhead].place.leaf);
      const FrameLeaf& seen = frame_leaves[i];
      const LeafIndex corner = seen.address.Corner(camera_leaf);
      const LeafPlace place = tree_.FindOrMake(seen, tree_.CellOf(corner), frame_id);
      if (place != seen.place) frame_leaves_.Remember(seen.address, place);
      Cell& cell = tree_.cell(place.cell);
      cell.weight += seen.moments.weight;
      report_.Touch(&cell);
      if (place.leaf == kNothing) continue;
      const double half = 0.5 * (1 << seen.address.level());
      const Eigen::Vector3d centre =
          config_.leaf_size_m * (corner.cast<double>() + Eigen::Vector3d::Constant(half));
      AddToLeaf(seen.moments, centre - camera_world, camera, place.leaf);
      Confirm(place.leaf, frame_id, &cell);
    }
  }

  void AddToLeaf(const PointMoments& moments, const Eigen::Vector3d& ray, const StereoCamera& camera,
                 int index) {
    Leaf& leaf = tree_.leaves().leaf(index);
    Evidence& evidence = tree_.leaves().evidence(index);
    if (evidence.num_frames < config_.memory_frames)
      ++evidence.num_frames;
    else
      leaf.Fade(1.0F - 1.0F / static_cast<float>(config_.memory_frames));
    const float range = std::max(static_cast<float>(ray.norm()), 1e-3F);
    leaf.Add(moments, ray.cast<float>() / range,
             static_cast<float>(config_.leaf_size_m * (1 << evidence.level)));
    const auto spacing_m = Eigen::half(range / static_cast<float>(camera.fx));
    if (leaf.spacing_m == Eigen::half(0.0F) || spacing_m < leaf.spacing_m) leaf.spacing_m = spacing_m;
  }

  void Confirm(int index, FrameId frame_id, Cell* cell) {
    const Leaf& leaf = tree_.leaves().leaf(index);
    Evidence& evidence = tree_.leaves().evidence(index);
    evidence.hit_frame = Evidence::FrameBits(frame_id);
    evidence.credit = static_cast<std::int8_t>(std::min(evidence.credit + 1, config_.free_frames));
    evidence.enough_points = leaf.num_points() >= static_cast<float>(config_.min_points) &&
                             evidence.num_frames >= config_.min_frames;
    // Coarse leaves, seen from afar, give way to a finer one that is well known.
    if (evidence.num_frames < kFramesToReplace) return;
    tree_.DropCoarser(cell);
    evidence.alone = true;
  }

  /// What nothing was added to for as long as a leaf remembers, and has not become occupied by then, is noise
  /// or hardly known: two leaves in five. Some cells are looked through in every frame, the next ones in the
  /// next.
  void DropOldNoise(FrameId frame_id) {
    const int num_slots = tree_.num_cell_slots();
    for (int i = 0; i < num_slots / kTidyTurns + 1 && num_slots > 0; ++i) {
      next_tidied_ = (next_tidied_ + 1) % num_slots;
      Cell& cell = tree_.cell(next_tidied_);
      if (cell.leaves.empty() || frame_id - cell.touched_frame <= config_.memory_frames) continue;
      tree_.DropUnoccupied(&cell);
      if (cell.leaves.empty()) report_.Touch(&cell);
    }
  }

  const MappingConfig config_;
  LeafTree tree_;
  FrameLeaves frame_leaves_;
  ViewTiles tiles_;
  ChangeReport report_;
  int next_tidied_ = 0;  // slot of a cell
};

TerrainOctree::TerrainOctree(const MappingConfig& config) : config_(config) {
  TERRACE_CHECK(config.Problems().empty());
  impl_ = std::make_unique<Impl>(config);
}
TerrainOctree::~TerrainOctree() = default;

ChangedCells TerrainOctree::Insert(const Cloud& cloud, const StereoCamera& camera, const PoseEstimate& pose) {
  return impl_->Insert(cloud, camera, pose);
}
std::vector<CellKey> TerrainOctree::ForgetBeyond(const Eigen::Vector3d& p_world, double radius_m) {
  return impl_->ForgetBeyond(p_world, radius_m);
}
void TerrainOctree::CollectSurfels(const CellKey& cell, std::vector<Surfel>* surfels) const {
  impl_->CollectSurfels(cell, surfels);
}
std::vector<OccupiedLeaf> TerrainOctree::LeavesIn(const Eigen::AlignedBox3d& box_world) const {
  return impl_->LeavesIn(box_world);
}
Eigen::Vector3d TerrainOctree::CellCentre(const CellKey& cell) const {
  return config_.cell_size_m() * (Eigen::Vector3d(cell.x, cell.y, cell.z) + Eigen::Vector3d::Constant(0.5));
}
std::int64_t TerrainOctree::num_leaves() const { return impl_->leaves().num_used(); }
std::int64_t TerrainOctree::num_occupied_leaves() const { return impl_->leaves().num_occupied(); }
std::int64_t TerrainOctree::memory_bytes() const { return impl_->memory_bytes(); }

}  // namespace terrace
