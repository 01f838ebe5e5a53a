// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/terrain_octree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <unordered_map>

#include <octomap/AbstractOcTree.h>
#include <octomap/OcTreeBaseImpl.h>
#include <octomap/OcTreeDataNode.h>

#include "core/check.h"

namespace terrace {
namespace {

constexpr unsigned kTreeDepth = 16;
constexpr int kKeyOffset = 1 << (kTreeDepth - 1);  // OctoMap's key of the world's origin
constexpr int kNothing = -1;
constexpr int kTilePx = 4;  // free space is judged by tiles of this many pixels

/// Weighted sums over the points of one leaf, from which mean and covariance follow without the points.
/// Points are taken relative to the leaf's centre, so that floats keep enough digits far from the origin.
struct PointMoments {
  float weight = 0.0F;  // sum of 1 / variance
  float num_points = 0.0F;
  std::array<float, 3> sum{};        // weight * p
  std::array<float, 6> sum_outer{};  // weight * p p^T: xx xy xz yy yz zz

  void Add(float w, const Eigen::Vector3f& p) {
    weight += w;
    num_points += 1.0F;
    const float wx = w * p.x(), wy = w * p.y(), wz = w * p.z();
    sum[0] += wx;
    sum[1] += wy;
    sum[2] += wz;
    sum_outer[0] += wx * p.x();
    sum_outer[1] += wx * p.y();
    sum_outer[2] += wx * p.z();
    sum_outer[3] += wy * p.y();
    sum_outer[4] += wy * p.z();
    sum_outer[5] += wz * p.z();
  }
  void Add(const PointMoments& other) {
    weight += other.weight;
    num_points += other.num_points;
    for (int i = 0; i < 3; ++i) sum[i] += other.sum[i];
    for (int i = 0; i < 6; ++i) sum_outer[i] += other.sum_outer[i];
  }
  void Scale(float factor) {
    weight *= factor;
    num_points *= factor;
    for (float& value : sum) value *= factor;
    for (float& value : sum_outer) value *= factor;
  }
};

struct Leaf {
  PointMoments moments;
  Eigen::Vector3f view_sum = Eigen::Vector3f::Zero();  // weight * unit direction of view
  float num_frames = 0.0F;                             // that put points into it
  float num_views = 0.0F;                              // that had it in view, nothing in front of it
  float spacing_m = 0.0F;
  int level = 0;
  bool occupied = false;
  int credit = 0;  // frames that hit it minus frames that saw through it; cleared below zero
};

struct Cell {
  float weight = 0.0F;         // all that was ever added
  float fitted_weight = 0.0F;  // `weight` when the cell was last reported
  bool leaves_changed = false;
  FrameId reported_frame = 0;
  FrameId touched_frame = -1;
};

/// Slots that are used again, addressed by index.
template <typename T>
class Pool {
 public:
  int Take() {
    if (!free_.empty()) {
      const int index = free_.back();
      free_.pop_back();
      items_[index] = T{};
      return index;
    }
    items_.emplace_back();
    return static_cast<int>(items_.size()) - 1;
  }
  void GiveBack(int index) { free_.push_back(index); }
  T& operator[](int index) { return items_[index]; }
  const T& operator[](int index) const { return items_[index]; }
  std::int64_t num_used() const { return static_cast<std::int64_t>(items_.size() - free_.size()); }
  std::int64_t memory_bytes() const {
    return static_cast<std::int64_t>(items_.capacity() * sizeof(T) + free_.capacity() * sizeof(int));
  }

 private:
  std::vector<T> items_;
  std::vector<int> free_;
};

/// The value of a node is a slot: of a Cell at the depth of cells, of a Leaf below, kNothing above and where
/// there are only finer leaves.
class Node : public octomap::OcTreeDataNode<int> {
 public:
  Node() : octomap::OcTreeDataNode<int>(kNothing) {}
};

/// OctoMap's own OcTreeBase does not compile as C++20.
class Tree : public octomap::OcTreeBaseImpl<Node, octomap::AbstractOcTree> {
 public:
  explicit Tree(double leaf_size_m) : OcTreeBaseImpl(leaf_size_m) {}

  Tree* create() const override { return new Tree(resolution); }
  std::string getTreeType() const override { return "TerraceTree"; }

  Node* MakeRoot() {
    if (root == nullptr) {
      root = new Node();  // owned and deleted by the base class
      ++tree_size;
    }
    return root;
  }
};

int ChildIndex(const octomap::OcTreeKey& key, unsigned child_depth) {
  return octomap::computeChildIdx(key, static_cast<int>(kTreeDepth - child_depth));
}

struct FrameLeaf {
  octomap::OcTreeKey key;  // of the leaf's lowest corner
  int level = 0;
  PointMoments moments;
};

/// The leaves that one frame touches: an open-addressing table that is emptied in no time.
class FrameLeaves {
 public:
  FrameLeaves() : slots_(std::size_t{1} << 15) {}

  void Clear() {
    leaves_.clear();
    ++generation_;
  }
  FrameLeaf& At(const octomap::OcTreeKey& key, int level) {
    const std::uint64_t packed = (std::uint64_t(level) << 48) | (std::uint64_t(key[0]) << 32) |
                                 (std::uint64_t(key[1]) << 16) | std::uint64_t(key[2]);
    if (packed == last_packed_ && last_generation_ == generation_) return leaves_[last_index_];
    if (leaves_.size() * 2 >= slots_.size()) Grow();
    Slot& slot = Find(packed);
    if (slot.generation != generation_) {
      slot = {packed, generation_, static_cast<std::uint32_t>(leaves_.size())};
      leaves_.push_back({key, level, {}});
    }
    last_packed_ = packed;
    last_generation_ = generation_;
    last_index_ = slot.index;
    return leaves_[slot.index];
  }
  const std::vector<FrameLeaf>& leaves() const { return leaves_; }
  std::int64_t memory_bytes() const {
    return static_cast<std::int64_t>(slots_.capacity() * sizeof(Slot) +
                                     leaves_.capacity() * sizeof(FrameLeaf));
  }

 private:
  struct Slot {
    std::uint64_t packed = 0;
    std::uint32_t generation = 0;
    std::uint32_t index = 0;
  };
  Slot& Find(std::uint64_t packed) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = (packed * 0x9E3779B97F4A7C15ULL) >> 20 & mask;
    while (slots_[at].generation == generation_ && slots_[at].packed != packed) at = (at + 1) & mask;
    return slots_[at];
  }
  void Grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.generation == generation_) Find(slot.packed) = slot;
  }

  std::vector<Slot> slots_;
  std::vector<FrameLeaf> leaves_;
  std::uint32_t generation_ = 1;
  std::uint64_t last_packed_ = 0;
  std::uint32_t last_generation_ = 0;
  std::uint32_t last_index_ = 0;
};

}  // namespace

std::vector<std::string> MappingConfig::Problems() const {
  std::vector<std::string> problems;
  if (!(leaf_size_m >= 0.002 && leaf_size_m <= 1.0))
    problems.push_back("mapping.leaf_size_m must be between 0.002 and 1");
  if (leaves_per_cell < 4 || leaves_per_cell > 64 || !std::has_single_bit(unsigned(leaves_per_cell)))
    problems.push_back("mapping.leaves_per_cell must be 4, 8, 16, 32 or 64");
  if (!(min_leaf_px >= 1.0 && min_leaf_px <= 100.0))
    problems.push_back("mapping.min_leaf_px must be between 1 and 100");
  if (min_points < 1) problems.push_back("mapping.min_points must be at least 1");
  if (min_frames < 1) problems.push_back("mapping.min_frames must be at least 1");
  if (!(min_hit_share >= 0.0 && min_hit_share < 1.0))
    problems.push_back("mapping.min_hit_share must be at least 0 and below 1");
  if (!(pose_sigma_m > 0.0 && pose_sigma_m <= 1.0))
    problems.push_back("mapping.pose_sigma_m must be above 0 and at most 1");
  if (memory_frames < 2) problems.push_back("mapping.memory_frames must be at least 2");
  if (!(free_margin_px > 0.0)) problems.push_back("mapping.free_margin_px must be above 0");
  if (free_frames < 1) problems.push_back("mapping.free_frames must be at least 1");
  return problems;
}

class TerrainOctree::Impl {
 public:
  Impl(const MappingConfig& config, const StereoCamera& camera)
      : config_(config),
        camera_(camera),
        cell_shift_(std::countr_zero(static_cast<unsigned>(config.leaves_per_cell))),
        cell_depth_(kTreeDepth - static_cast<unsigned>(cell_shift_)),
        max_level_(cell_shift_ - 2),  // at least 4 leaves along the edge of a cell
        tree_(config.leaf_size_m),
        tiles_x_((camera.width + kTilePx - 1) / kTilePx),
        tiles_y_((camera.height + kTilePx - 1) / kTilePx),
        tile_disparity_(static_cast<std::size_t>(tiles_x_) * tiles_y_, 0.0F) {}

  ChangedCells Insert(const Cloud& cloud, const PoseEstimate& pose) {
    ChangedCells changed{cloud.frame_id, cloud.t_capture, {}};
    if (pose.status != TrackingStatus::kTracking) return changed;  // a guessed pose would smear the map
    touched_.clear();
    SumPoints(cloud, pose.T_world_left);
    AddToTree(cloud.frame_id, pose.T_world_left.translation());
    ClearFreeSpace(cloud.frame_id, pose.T_world_left);
    ReportChanged(cloud.frame_id, &changed);
    return changed;
  }

  void CollectSurfels(const CellKey& cell, std::vector<Surfel>* surfels) const {
    surfels->clear();
    const Node* node = FindCell(cell);
    if (node == nullptr) return;
    const int half = config_.leaves_per_cell / 2;
    CollectFrom(node, cell_depth_, Eigen::Vector3i::Constant(-half), surfels);
  }

  Eigen::Vector3d CellCentre(const CellKey& cell) const {
    return config_.cell_size_m() * (Eigen::Vector3d(cell.x, cell.y, cell.z) + Eigen::Vector3d::Constant(0.5));
  }

  std::int64_t num_occupied_leaves() const { return leaves_.num_used(); }

  std::int64_t memory_bytes() const {
    // OctoMap counts nodes and the arrays of their children.
    return static_cast<std::int64_t>(tree_.memoryUsage()) + leaves_.memory_bytes() + cells_.memory_bytes() +
           frame_leaves_.memory_bytes();
  }

 private:
  /// Points to leaves of the frame, and to tiles of the image for free space.
  void SumPoints(const Cloud& cloud, const Eigen::Isometry3d& T_world_left) {
    frame_leaves_.Clear();
    std::fill(tile_disparity_.begin(), tile_disparity_.end(), 0.0F);
    const Eigen::Matrix3d R = T_world_left.linear();
    const Eigen::Vector3d t = T_world_left.translation();
    const double leaves_per_m = 1.0 / config_.leaf_size_m;
    const float pose_variance = static_cast<float>(config_.pose_sigma_m * config_.pose_sigma_m);
    const float leaf_m = static_cast<float>(config_.leaf_size_m);
    const float fb = static_cast<float>(camera_.fx * camera_.baseline_m);
    // Level l is used while a leaf is min_leaf_px wide: z <= max_z[l].
    std::array<float, 8> max_z{};
    for (int level = 0; level < max_level_; ++level)
      max_z[level] =
          static_cast<float>(config_.leaf_size_m * (1 << level) * camera_.fx / config_.min_leaf_px);
    for (const CloudPoint& point : cloud.points) {
      const float z = point.p_left.z();
      const float variance = point.sigma_depth_m * point.sigma_depth_m + pose_variance;
      const Eigen::Vector3d p = R * point.p_left.cast<double>() + t;
      const Eigen::Vector3d in_leaves = p * leaves_per_m;
      // Also false for anything that is not a number.
      if (!(z > 0.0F && variance > 0.0F && in_leaves.cwiseAbs().maxCoeff() < kKeyOffset - 1)) continue;
      int level = 0;
      while (level < max_level_ && z > max_z[level]) ++level;
      std::array<int, 3> index{};
      Eigen::Vector3f offset;
      for (int i = 0; i < 3; ++i) {
        index[i] = (static_cast<int>(in_leaves[i] + kKeyOffset) >> level) << level;
        offset[i] = (static_cast<float>(in_leaves[i] + kKeyOffset - index[i]) - 0.5F * (1 << level)) * leaf_m;
      }
      FrameLeaf& leaf = frame_leaves_.At(octomap::OcTreeKey(static_cast<octomap::key_type>(index[0]),
                                                            static_cast<octomap::key_type>(index[1]),
                                                            static_cast<octomap::key_type>(index[2])),
                                         level);
      leaf.moments.Add(1.0F / variance, offset);
      const Eigen::Vector2d uv = camera_.Project(point.p_left.cast<double>());
      const int tile_u = static_cast<int>(uv.x() + 0.5) / kTilePx;
      const int tile_v = static_cast<int>(uv.y() + 0.5) / kTilePx;
      if (tile_u >= 0 && tile_v >= 0 && tile_u < tiles_x_ && tile_v < tiles_y_) {
        float& tile = tile_disparity_[static_cast<std::size_t>(tile_v) * tiles_x_ + tile_u];
        tile = std::max(tile, fb / z);
      }
    }
  }

  void AddToTree(FrameId frame_id, const Eigen::Vector3d& camera_world) {
    for (const FrameLeaf& seen : frame_leaves_.leaves()) {
      Node* node = CellNodeOf(seen.key);
      Cell& cell = cells_[node->getValue()];
      if (cell.touched_frame != frame_id) {
        cell.touched_frame = frame_id;
        touched_.push_back(KeyOf(seen.key));
      }
      cell.weight += seen.moments.weight;
      // Down to the leaf. A coarse leaf on the way, seen from afar, gives way to the finer one.
      const unsigned depth = kTreeDepth - static_cast<unsigned>(seen.level);
      for (unsigned child_depth = cell_depth_ + 1; child_depth <= depth; ++child_depth) {
        const unsigned child = static_cast<unsigned>(ChildIndex(seen.key, child_depth));
        if (!tree_.nodeChildExists(node, child)) {
          node = tree_.createNodeChild(node, child);
        } else {
          node = tree_.getNodeChild(node, child);
          if (child_depth < depth && node->getValue() != kNothing) {
            leaves_.GiveBack(node->getValue());
            node->setValue(kNothing);
          }
        }
      }
      if (tree_.nodeHasChildren(node)) continue;  // known more finely already
      if (node->getValue() == kNothing) {
        node->setValue(leaves_.Take());
        leaves_[node->getValue()].level = seen.level;
      }
      AddToLeaf(seen, camera_world, &leaves_[node->getValue()]);
    }
  }

  void AddToLeaf(const FrameLeaf& seen, const Eigen::Vector3d& camera_world, Leaf* leaf) const {
    if (leaf->num_frames >= static_cast<float>(config_.memory_frames)) {
      const float fade = 1.0F - 1.0F / static_cast<float>(config_.memory_frames);
      leaf->moments.Scale(fade);
      leaf->view_sum *= fade;
      leaf->num_frames *= fade;
      leaf->num_views *= fade;
    }
    const double half = 0.5 * (1 << seen.level);
    const Eigen::Vector3d centre =
        config_.leaf_size_m * (Eigen::Vector3d(seen.key[0], seen.key[1], seen.key[2]) +
                               Eigen::Vector3d::Constant(half - kKeyOffset));
    const Eigen::Vector3d ray = centre - camera_world;
    const float range = static_cast<float>(ray.norm());
    leaf->view_sum += seen.moments.weight / std::max(range, 1e-3F) * ray.cast<float>();
    leaf->moments.Add(seen.moments);
    leaf->num_frames += 1.0F;
    const float spacing = range / static_cast<float>(camera_.fx);
    if (leaf->spacing_m == 0.0F || spacing < leaf->spacing_m) leaf->spacing_m = spacing;
    leaf->credit = std::min(leaf->credit + 1, config_.free_frames);
  }

  /// Walks the octree inside the field of view and clears leaves behind which the image shows something.
  void ClearFreeSpace(FrameId frame_id, const Eigen::Isometry3d& T_world_left) {
    Node* root = tree_.getRoot();
    if (root == nullptr) return;
    T_left_world_ = T_world_left.inverse();
    float least = std::numeric_limits<float>::infinity();
    for (const float disparity : tile_disparity_)
      if (disparity > 0.0F) least = std::min(least, disparity);
    if (!std::isfinite(least)) return;
    farthest_m_ = camera_.Depth(least);
    frame_id_ = frame_id;
    ClearBelow(root, 0, {0, 0, 0});
  }

  /// Returns true when the node holds nothing any more.
  bool ClearBelow(Node* node, unsigned depth, const Eigen::Vector3i& corner) {
    const int size = 1 << (kTreeDepth - depth);
    const Eigen::Vector3d centre_world =
        config_.leaf_size_m * (corner.cast<double>() + Eigen::Vector3d::Constant(0.5 * size - kKeyOffset));
    const Eigen::Vector3d centre = T_left_world_ * centre_world;
    const double radius = 0.5 * std::sqrt(3.0) * size * config_.leaf_size_m;
    if (!InView(centre, radius)) return false;
    if (depth == cell_depth_) cell_in_view_ = node;
    if (depth > cell_depth_ && node->getValue() != kNothing) {
      Leaf& leaf = leaves_[node->getValue()];
      const bool was_occupied = leaf.occupied;
      const View view = ViewOf(centre, radius);
      if (view != View::kNone) leaf.num_views += 1.0F;
      const bool cleared = view == View::kThrough && --leaf.credit < 0;
      leaf.occupied = !cleared && IsOccupied(leaf);
      if (leaf.occupied != was_occupied) {
        Cell& cell = cells_[cell_in_view_->getValue()];
        cell.leaves_changed = true;
        if (cell.touched_frame != frame_id_) {
          cell.touched_frame = frame_id_;
          touched_.push_back(KeyOf(octomap::OcTreeKey(static_cast<octomap::key_type>(corner.x()),
                                                      static_cast<octomap::key_type>(corner.y()),
                                                      static_cast<octomap::key_type>(corner.z()))));
        }
      }
      if (cleared) {
        leaves_.GiveBack(node->getValue());
        node->setValue(kNothing);
      }
    }
    if (depth < kTreeDepth && tree_.nodeHasChildren(node)) {
      for (unsigned child = 0; child < 8; ++child) {
        if (!tree_.nodeChildExists(node, child)) continue;
        const Eigen::Vector3i child_corner =
            corner + size / 2 * Eigen::Vector3i(child & 1U, (child >> 1U) & 1U, (child >> 2U) & 1U);
        // Cells stay, empty or not: they remember that their emptiness must still be reported.
        if (ClearBelow(tree_.getNodeChild(node, child), depth + 1, child_corner) && depth >= cell_depth_)
          tree_.deleteNodeChild(node, child);
      }
      if (depth > cell_depth_ && !HasAnyChild(node)) return node->getValue() == kNothing;
      return false;
    }
    return depth > cell_depth_ && node->getValue() == kNothing;
  }

  bool HasAnyChild(const Node* node) const { return tree_.nodeHasChildren(node); }

  bool InView(const Eigen::Vector3d& centre, double radius) const {
    if (centre.z() + radius <= 0.0 || centre.z() - radius > farthest_m_) return false;
    // Outside one of the four planes through the camera and an edge of the image.
    const double left = -camera_.cx / camera_.fx, right = (camera_.width - 1 - camera_.cx) / camera_.fx;
    const double top = -camera_.cy / camera_.fy, bottom = (camera_.height - 1 - camera_.cy) / camera_.fy;
    const double z = centre.z();
    return centre.x() - left * z > -radius * std::hypot(1.0, left) &&
           right * z - centre.x() > -radius * std::hypot(1.0, right) &&
           centre.y() - top * z > -radius * std::hypot(1.0, top) &&
           bottom * z - centre.y() > -radius * std::hypot(1.0, bottom);
  }

  enum class View { kNone, kOnto, kThrough };

  /// What the image says of a place: nothing, or that something may be there, or that it looked through.
  View ViewOf(const Eigen::Vector3d& centre, double radius) const {
    if (centre.z() <= 0.05) return View::kNone;
    const Eigen::Vector2d uv = camera_.Project(centre);
    const int u = static_cast<int>(std::floor((uv.x() + 0.5) / kTilePx - 0.5));
    const int v = static_cast<int>(std::floor((uv.y() + 0.5) / kTilePx - 0.5));
    if (u < 0 || v < 0 || u + 1 >= tiles_x_ || v + 1 >= tiles_y_) return View::kNone;
    float nearest = 0.0F;  // over the four tiles around; one without points proves nothing
    for (const int dv : {0, 1}) {
      for (const int du : {0, 1}) {
        const float disparity = tile_disparity_[static_cast<std::size_t>(v + dv) * tiles_x_ + u + du];
        if (disparity == 0.0F) return View::kNone;
        nearest = std::max(nearest, disparity);
      }
    }
    if (camera_.Disparity(centre.z() + radius) > nearest + config_.free_margin_px) return View::kThrough;
    const double near_end = std::max(0.05, centre.z() - radius);
    return nearest > camera_.Disparity(near_end) + config_.free_margin_px ? View::kNone : View::kOnto;
  }

  void ReportChanged(FrameId frame_id, ChangedCells* changed) {
    std::sort(touched_.begin(), touched_.end());
    for (const CellKey& key : touched_) {
      Cell& cell = cells_[FindCell(key)->getValue()];
      const bool heavier = cell.weight > kWorthAFit * cell.fitted_weight;
      const bool old = frame_id - cell.reported_frame >= config_.memory_frames / 4;
      if (!cell.leaves_changed && !heavier && !old) continue;
      cell.fitted_weight = cell.weight;
      cell.leaves_changed = false;
      cell.reported_frame = frame_id;
      changed->keys.push_back(key);
    }
  }

  Node* CellNodeOf(const octomap::OcTreeKey& key) {
    const CellKey cell_key = KeyOf(key);
    if (last_cell_node_ != nullptr && last_cell_key_ == cell_key) return last_cell_node_;
    Node* node = tree_.MakeRoot();
    for (unsigned depth = 1; depth <= cell_depth_; ++depth) {
      const unsigned child = static_cast<unsigned>(ChildIndex(key, depth));
      node = tree_.nodeChildExists(node, child) ? tree_.getNodeChild(node, child)
                                                : tree_.createNodeChild(node, child);
    }
    if (node->getValue() == kNothing) node->setValue(cells_.Take());
    last_cell_key_ = cell_key;
    last_cell_node_ = node;
    return node;
  }

  CellKey KeyOf(const octomap::OcTreeKey& key) const {
    return {(int(key[0]) - kKeyOffset) >> cell_shift_, (int(key[1]) - kKeyOffset) >> cell_shift_,
            (int(key[2]) - kKeyOffset) >> cell_shift_};
  }

  Node* FindCell(const CellKey& cell) const {
    const Eigen::Vector3i corner = Eigen::Vector3i(cell.x, cell.y, cell.z) * config_.leaves_per_cell +
                                   Eigen::Vector3i::Constant(kKeyOffset);
    if (corner.minCoeff() < 0 || corner.maxCoeff() >= 2 * kKeyOffset) return nullptr;
    return tree_.search(octomap::OcTreeKey(static_cast<octomap::key_type>(corner.x()),
                                           static_cast<octomap::key_type>(corner.y()),
                                           static_cast<octomap::key_type>(corner.z())),
                        cell_depth_);
  }

  bool IsOccupied(const Leaf& leaf) const {
    return leaf.moments.num_points >= static_cast<float>(config_.min_points) &&
           leaf.num_frames >= static_cast<float>(config_.min_frames) &&
           leaf.num_frames >= static_cast<float>(config_.min_hit_share) * leaf.num_views;
  }

  /// @param corner  lowest corner in finest leaves, relative to the centre of the cell
  void CollectFrom(const Node* node, unsigned depth, const Eigen::Vector3i& corner,
                   std::vector<Surfel>* surfels) const {
    const int size = 1 << (kTreeDepth - depth);
    if (depth > cell_depth_ && node->getValue() != kNothing) {
      const Leaf& leaf = leaves_[node->getValue()];
      if (leaf.occupied) surfels->push_back(SurfelOf(leaf, corner, size));
    }
    if (depth == kTreeDepth || !tree_.nodeHasChildren(node)) return;
    for (unsigned child = 0; child < 8; ++child) {
      if (!tree_.nodeChildExists(node, child)) continue;
      const Eigen::Vector3i child_corner =
          corner + size / 2 * Eigen::Vector3i(child & 1U, (child >> 1U) & 1U, (child >> 2U) & 1U);
      CollectFrom(tree_.getNodeChild(node, child), depth + 1, child_corner, surfels);
    }
  }

  Surfel SurfelOf(const Leaf& leaf, const Eigen::Vector3i& corner, int size) const {
    const PointMoments& m = leaf.moments;
    const float leaf_m = static_cast<float>(config_.leaf_size_m);
    const Eigen::Vector3f centre =
        leaf_m * (corner.cast<float>() + Eigen::Vector3f::Constant(0.5F * static_cast<float>(size)));
    const Eigen::Vector3f mean = Eigen::Vector3f(m.sum[0], m.sum[1], m.sum[2]) / m.weight;
    Surfel surfel;
    surfel.mean = centre + mean;
    Eigen::Matrix3f outer;
    outer << m.sum_outer[0], m.sum_outer[1], m.sum_outer[2],  //
        m.sum_outer[1], m.sum_outer[3], m.sum_outer[4],       //
        m.sum_outer[2], m.sum_outer[4], m.sum_outer[5];
    surfel.covariance = outer / m.weight - mean * mean.transpose();
    surfel.view = leaf.view_sum.normalized();
    // Points are weighted by 1 / variance, so count over weight is their mean variance.
    surfel.sigma_view_m = std::sqrt(m.num_points / m.weight);
    surfel.num_points = m.num_points;
    surfel.num_frames = leaf.num_frames;
    surfel.size_m = static_cast<float>(size) * leaf_m;
    surfel.spacing_m = leaf.spacing_m;
    return surfel;
  }

  static constexpr float kWorthAFit = 1.1F;  // a tenth more weight

  const MappingConfig config_;
  const StereoCamera camera_;
  const int cell_shift_;
  const unsigned cell_depth_;
  const int max_level_;
  Tree tree_;
  Pool<Leaf> leaves_;
  Pool<Cell> cells_;
  FrameLeaves frame_leaves_;
  std::vector<CellKey> touched_;
  CellKey last_cell_key_;
  Node* last_cell_node_ = nullptr;

  // Of the frame at hand, for free space.
  const int tiles_x_;
  const int tiles_y_;
  std::vector<float> tile_disparity_;  // greatest, that is nearest, in each tile; 0 = no point
  Eigen::Isometry3d T_left_world_ = Eigen::Isometry3d::Identity();
  double farthest_m_ = 0.0;
  FrameId frame_id_ = 0;
  Node* cell_in_view_ = nullptr;
};

TerrainOctree::TerrainOctree(const MappingConfig& config, const StereoCamera& camera) : config_(config) {
  TERRACE_CHECK(config.Problems().empty());
  impl_ = std::make_unique<Impl>(config, camera);
}
TerrainOctree::~TerrainOctree() = default;

ChangedCells TerrainOctree::Insert(const Cloud& cloud, const PoseEstimate& pose) {
  return impl_->Insert(cloud, pose);
}
void TerrainOctree::CollectSurfels(const CellKey& cell, std::vector<Surfel>* surfels) const {
  impl_->CollectSurfels(cell, surfels);
}
Eigen::Vector3d TerrainOctree::CellCentre(const CellKey& cell) const { return impl_->CellCentre(cell); }
std::int64_t TerrainOctree::num_occupied_leaves() const { return impl_->num_occupied_leaves(); }
std::int64_t TerrainOctree::memory_bytes() const { return impl_->memory_bytes(); }

}  // namespace terrace
