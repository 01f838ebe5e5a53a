// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/free_space.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "mapping/point_summing.h"

namespace terrace {
namespace {

constexpr FrameId kTurns = 2;  // a power of two

/// Rounded up.
std::uint16_t Half(std::uint16_t count) { return static_cast<std::uint16_t>((count + 1) / 2); }

}  // namespace

FreeSpace::FreeSpace(const MappingConfig& config, const StereoCamera& camera,
                     const Eigen::Isometry3d& T_world_left, FrameId frame_id, const ViewTiles& tiles)
    : config_(config),
      tiles_(tiles),
      frame_id_(frame_id),
      camera_leaf_(LeafAt(T_world_left.translation(), config)),
      T_left_world_(T_world_left.inverse()),
      R_left_leaves_((T_left_world_.linear() * config.leaf_size_m).cast<float>()) {
  const float farthest_px = tiles.farthest_px();
  // Nothing is known of this image: nothing is in view.
  if (std::isfinite(farthest_px)) farthest_m_ = camera.Depth(farthest_px);
  const double left = -camera.cx / camera.fx, right = (camera.width - 1 - camera.cx) / camera.fx;
  const double top = -camera.cy / camera.fy, bottom = (camera.height - 1 - camera.cy) / camera.fy;
  sides_ = {Eigen::Vector3d(1, 0, -left).normalized(), Eigen::Vector3d(-1, 0, right).normalized(),
            Eigen::Vector3d(0, 1, -top).normalized(), Eigen::Vector3d(0, -1, bottom).normalized()};
}

Eigen::Vector3d FreeSpace::CentreInLeft(const LeafIndex& corner, int size) const {
  return T_left_world_ *
         (config_.leaf_size_m * (corner.cast<double>() + Eigen::Vector3d::Constant(0.5 * size)));
}

bool FreeSpace::MayBeInView(const LeafIndex& corner, int size) const {
  const Eigen::Vector3d centre = CentreInLeft(corner, size);
  const double radius = 0.5 * std::sqrt(3.0) * size * config_.leaf_size_m;
  if (farthest_m_ <= 0.0 || centre.z() + radius <= 0.0 || centre.z() - radius > farthest_m_) return false;
  for (const Eigen::Vector3d& side : sides_)
    if (side.dot(centre) < -radius) return false;
  return true;
}

bool FreeSpace::HasItsTurn(const CellKey& key) const {
  return ((key.x + key.y + key.z + frame_id_) & (kTurns - 1)) == 0;
}

void FreeSpace::CheckLeaves(const LeafIndex& corner, Cell* cell, LeafTree* tree) const {
  const Eigen::Vector3f corner_left =
      CentreInLeft(corner, config_.leaves_per_cell).cast<float>() -
      R_left_leaves_ * Eigen::Vector3f::Constant(0.5F * static_cast<float>(config_.leaves_per_cell));
  std::size_t next = 0;
  const auto is_cleared = [&](int index) {
    // They lie scattered over memory, which is asked for those to come.
    constexpr std::size_t kAhead = 8;
    if (++next + kAhead <= cell->leaves.size()) tree->leaves().PrefetchEvidence(cell->leaves[next + kAhead - 1]);
    Evidence& leaf = tree->leaves().evidence(index);
    const Eigen::Vector3i in_cell(leaf.corner[0], leaf.corner[1], leaf.corner[2]);
    const LeafState state = CheckLeaf(in_cell, corner_left, &leaf);
    if ((state == LeafState::kOccupied) != (leaf.occupied != 0)) ++cell->num_changed_leaves;
    tree->leaves().SetOccupied(index, state == LeafState::kOccupied);
    if (state == LeafState::kCleared) tree->leaves().GiveBack(index);
    return state == LeafState::kCleared;
  };
  std::erase_if(cell->leaves, is_cleared);
}

FreeSpace::LeafState FreeSpace::CheckLeaf(const Eigen::Vector3i& in_cell, const Eigen::Vector3f& corner_left,
                                          Evidence* leaf) const {
  const float half = 0.5F * static_cast<float>(1 << leaf->level);
  const Eigen::Vector3f centre =
      corner_left + R_left_leaves_ * (in_cell.cast<float>() + Eigen::Vector3f::Constant(half));
  const ViewTiles::View view = tiles_.ViewOf(centre, 1.74F * half * static_cast<float>(config_.leaf_size_m),
                                             static_cast<float>(config_.free_margin_px));
  if (view != ViewTiles::View::kNone) {
    ++leaf->num_views;
    if (leaf->hit_frame == Evidence::FrameBits(frame_id_)) ++leaf->num_hits;
    if (leaf->num_views > config_.memory_frames) {
      leaf->num_views = Half(leaf->num_views);
      leaf->num_hits = Half(leaf->num_hits);
    }
  }
  if (view == ViewTiles::View::kThrough && --leaf->credit < 0) return LeafState::kCleared;
  return IsOccupied(*leaf) ? LeafState::kOccupied : LeafState::kNoise;
}

bool FreeSpace::IsOccupied(const Evidence& leaf) const {
  return leaf.enough_points && leaf.num_hits >= config_.min_hit_share * leaf.num_views;
}

}  // namespace terrace
