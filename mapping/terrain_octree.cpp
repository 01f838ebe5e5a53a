// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/terrain_octree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include <octomap/AbstractOcTree.h>
#include <octomap/OcTreeBaseImpl.h>
#include <octomap/OcTreeDataNode.h>

#include "core/check.h"
#include "mapping/frame_leaves.h"
#include "mapping/leaf_pool.h"

namespace terrace {
namespace {

constexpr unsigned kTreeDepth = 16;
constexpr int kKeyOffset = 1 << (kTreeDepth - 1);  // OctoMap's key of the world's origin
constexpr int kTilePx = 4;  // free space is judged by tiles of this many pixels

/// Where a leaf of a cell comes when the octree is walked: eighth by eighth, coarse ones before what they
/// hold.
int Rank(const Evidence& leaf) {
  int rank = 0;
  for (int bit = 5; bit >= 0; --bit)
    for (int axis = 2; axis >= 0; --axis) rank = 2 * rank + (leaf.corner[axis] >> bit & 1);
  return 8 * rank + 7 - leaf.level;
}

struct Cell {
  std::vector<int> leaves;     // that it holds, in the order of the octree
  float weight = 0.0F;         // all that was ever added
  float fitted_weight = 0.0F;  // `weight` when the cell was last reported
  int num_changed_leaves = 0;  // occupied or no longer, since it was last reported
  FrameId reported_frame = -1000;
  FrameId touched_frame = -1;
};

/// The value of a node is a slot: of a Cell at the depth of cells, of a Leaf below, kNothing above and where
/// there are only finer leaves.
class Node : public octomap::OcTreeDataNode<int> {
 public:
  Node() : octomap::OcTreeDataNode<int>(kNothing) {}

  bool HasArrayOfChildren() const { return children != nullptr; }

  /// OctoMap keeps the array of children when the last child is deleted, and expects it gone with the node.
  /// True when there was one to be released.
  bool ReleaseEmptyChildren() {
    if (children == nullptr ||
        std::any_of(children, children + 8, [](auto* child) { return child != nullptr; }))
      return false;
    delete[] children;
    children = nullptr;
    return true;
  }
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
  Node* GetOrMakeChild(Node* node, unsigned child) {
    if (nodeChildExists(node, child)) return getNodeChild(node, child);
    if (!node->HasArrayOfChildren()) ++num_arrays_;
    return createNodeChild(node, child);
  }
  void ReleaseEmptyChildren(Node* node) {
    if (node->ReleaseEmptyChildren()) --num_arrays_;
  }
  /// OctoMap's own memoryUsage() walks the whole tree.
  std::int64_t memory_bytes() const {
    return static_cast<std::int64_t>(size() * sizeof(Node)) +
           num_arrays_ * static_cast<std::int64_t>(8 * sizeof(Node*));
  }

 private:
  std::int64_t num_arrays_ = 0;
};

int ChildIndex(const octomap::OcTreeKey& key, unsigned child_depth) {
  return octomap::computeChildIdx(key, static_cast<int>(kTreeDepth - child_depth));
}

/// std::floor without a call into the C library; |x| below 2^31.
int Floor(float x) {
  const int towards_zero = static_cast<int>(x);
  return towards_zero - static_cast<int>(static_cast<float>(towards_zero) > x);
}

}  // namespace

std::vector<std::string> MappingConfig::Problems() const {
  std::vector<std::string> problems;
  if (!(leaf_size_m >= 0.002 && leaf_size_m <= 1.0))
    problems.push_back("leaf_size_m must be between 0.002 and 1");
  if (leaves_per_cell < 4 || leaves_per_cell > 64 || !std::has_single_bit(unsigned(leaves_per_cell)))
    problems.push_back("leaves_per_cell must be 4, 8, 16, 32 or 64");
  if (!(min_leaf_px >= 1.0 && min_leaf_px <= 100.0))
    problems.push_back("min_leaf_px must be between 1 and 100");
  if (min_points < 1) problems.push_back("min_points must be at least 1");
  if (min_frames < 1) problems.push_back("min_frames must be at least 1");
  if (!(min_hit_share >= 0.0 && min_hit_share < 1.0))
    problems.push_back("min_hit_share must be at least 0 and below 1");
  if (!(depth_sigma_factor > 0.0 && depth_sigma_factor <= 100.0))
    problems.push_back("depth_sigma_factor must be above 0 and at most 100");
  if (!(pose_sigma_m > 0.0 && pose_sigma_m <= 1.0))
    problems.push_back("pose_sigma_m must be above 0 and at most 1");
  if (memory_frames < 2) problems.push_back("memory_frames must be at least 2");
  if (!(free_margin_px > 0.0)) problems.push_back("free_margin_px must be above 0");
  if (free_frames < 1) problems.push_back("free_frames must be at least 1");
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
        frame_leaves_(camera.width),
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
    for (const int index : cells_[node->getValue()].leaves) {
      const Evidence& evidence = leaves_.evidence(index);
      if (evidence.occupied) surfels->push_back(SurfelOf(leaves_.leaf(index), evidence));
    }
  }

  Eigen::Vector3d CellCentre(const CellKey& cell) const {
    return config_.cell_size_m() * (Eigen::Vector3d(cell.x, cell.y, cell.z) + Eigen::Vector3d::Constant(0.5));
  }

  std::int64_t num_occupied_leaves() const { return leaves_.num_used(); }

  std::int64_t memory_bytes() const {
    const auto lists = leaves_.num_used() * static_cast<std::int64_t>(sizeof(int));  // Cell::leaves
    return tree_.memory_bytes() + leaves_.memory_bytes() + cells_.memory_bytes() + lists +
           frame_leaves_.memory_bytes();
  }

 private:
  /// Points to leaves of the frame, and to tiles of the image for free space.
  void SumPoints(const Cloud& cloud, const Eigen::Isometry3d& T_world_left) {
    frame_leaves_.Clear();
    std::fill(tile_disparity_.begin(), tile_disparity_.end(), 0.0F);
    // In units of the finest leaf, from OctoMap's lowest corner; the camera's own leaf is split off, so that
    // floats suffice for what is left.
    const double leaves_per_m = 1.0 / config_.leaf_size_m;
    const Eigen::Vector3d camera_leaves =
        T_world_left.translation() * leaves_per_m + Eigen::Vector3d::Constant(kKeyOffset);
    if (!(camera_leaves.minCoeff() >= 0.0 && camera_leaves.maxCoeff() < 2 * kKeyOffset)) return;
    const Eigen::Vector3i camera_leaf = camera_leaves.cast<int>();
    const Eigen::Vector3f in_camera_leaf = (camera_leaves - camera_leaf.cast<double>()).cast<float>();
    const Eigen::Matrix3f R = (T_world_left.linear() * leaves_per_m).cast<float>();
    const float pose_variance = static_cast<float>(config_.pose_sigma_m * config_.pose_sigma_m);
    const float sigma_factor = static_cast<float>(config_.depth_sigma_factor);
    const float leaf_m = static_cast<float>(config_.leaf_size_m);
    const float fb = static_cast<float>(camera_.fx * camera_.baseline_m);
    // Level l is used while a leaf is min_leaf_px wide: z <= max_z[l].
    std::array<float, 8> max_z{};
    for (int level = 0; level < max_level_; ++level)
      max_z[level] =
          static_cast<float>(config_.leaf_size_m * (1 << level) * camera_.fx / config_.min_leaf_px);
    for (const CloudPoint& point : cloud.points) {
      const float sigma = sigma_factor * point.sigma_depth_m;
      const float variance = sigma * sigma + pose_variance;
      const Eigen::Vector3f p = R * point.p_left + in_camera_leaf;
      // Also false for anything that is not a number.
      const auto within = [](float x) { return std::abs(x) < kKeyOffset; };
      if (!(InImage(point) && variance > 0.0F && within(p.x()) && within(p.y()) && within(p.z()))) continue;
      int level = 0;
      while (level < max_level_ && point.p_left.z() > max_z[level]) ++level;
      const Eigen::Vector3i floor(Floor(p.x()), Floor(p.y()), Floor(p.z()));
      Eigen::Vector3i index = camera_leaf + floor;
      if (index.minCoeff() < 0 || index.maxCoeff() >= 2 * kKeyOffset) continue;
      Eigen::Vector3f offset =
          p - floor.cast<float>() - Eigen::Vector3f::Constant(0.5F * static_cast<float>(1 << level));
      for (int i = 0; i < 3; ++i) {
        const int low = (index[i] >> level) << level;
        offset[i] += static_cast<float>(index[i] - low);
        index[i] = low;
      }
      FrameLeaf& leaf = frame_leaves_.At(AddressOf(index, level), point.u);
      leaf.moments.Add(1.0F / variance, offset * leaf_m);
      float& tile = TileAt(point);
      tile = std::max(tile, fb / point.p_left.z());
    }
    // As near as they may well be.
    constexpr float kSigmas = 2.0F;
    for (const CloudPoint& point : cloud.uncertain) {
      if (!InImage(point)) continue;
      const float z = point.p_left.z();
      float& tile = TileAt(point);
      tile = std::max(tile, fb / z * (1.0F + kSigmas * point.sigma_depth_m / z));
    }
  }

  /// False for anything that is not a number.
  bool InImage(const CloudPoint& point) const {
    return point.p_left.z() > 0.0F && point.u < camera_.width && point.v < camera_.height;
  }

  float& TileAt(const CloudPoint& point) {
    return tile_disparity_[static_cast<std::size_t>(point.v / kTilePx) * tiles_x_ + point.u / kTilePx];
  }

  static LeafAddress AddressOf(const Eigen::Vector3i& index, int level) {
    return {static_cast<std::uint16_t>(index.x()), static_cast<std::uint16_t>(index.y()),
            static_cast<std::uint16_t>(index.z()), level};
  }

  std::array<std::uint8_t, 3> CornerInCell(const LeafAddress& address) const {
    const int in_cell = config_.leaves_per_cell - 1;
    return {static_cast<std::uint8_t>(address.x() & in_cell), static_cast<std::uint8_t>(address.y() & in_cell),
            static_cast<std::uint8_t>(address.z() & in_cell)};
  }

  static octomap::OcTreeKey KeyAt(const LeafAddress& address) {
    return {address.x(), address.y(), address.z()};
  }
  static octomap::OcTreeKey KeyAt(const Eigen::Vector3i& index) {
    return {static_cast<octomap::key_type>(index.x()), static_cast<octomap::key_type>(index.y()),
            static_cast<octomap::key_type>(index.z())};
  }

  void AddToTree(FrameId frame_id, const Eigen::Vector3d& camera_world) {
    constexpr std::size_t kAhead = 8;  // leaves that memory has time for while others are added to
    const std::vector<FrameLeaf>& frame_leaves = frame_leaves_.leaves();
    for (std::size_t i = 0; i < frame_leaves.size(); ++i) {
      if (i + kAhead < frame_leaves.size() && frame_leaves[i + kAhead].place.leaf != kNothing)
        leaves_.Prefetch(frame_leaves[i + kAhead].place.leaf);
      const FrameLeaf& seen = frame_leaves[i];
      coarse_.clear();
      const LeafPlace place = IsStill(seen) ? seen.place : FindOrMake(seen.address, frame_id);
      Cell& cell = cells_[place.cell];
      cell.weight += seen.moments.weight;
      Touch(KeyOf(KeyAt(seen.address)), frame_id, &cell);
      if (place.leaf != kNothing) AddLeaf(seen, place.leaf, frame_id, camera_world, &cell);
    }
  }

  /// Whether the leaf is where an earlier frame found it, and without coarser ones above it.
  bool IsStill(const FrameLeaf& seen) const {
    if (seen.place.leaf == kNothing) return false;
    const Evidence& evidence = leaves_.evidence(seen.place.leaf);
    return evidence.cell == seen.place.cell && evidence.level == seen.address.level() &&
           evidence.corner == CornerInCell(seen.address) && evidence.alone;
  }

  /// Walks down the octree to a leaf, and makes it; no leaf where the place is known more finely already. The
  /// coarser leaves on the way are hit, too, and left in `coarse_`.
  LeafPlace FindOrMake(LeafAddress address, FrameId frame_id) {
    const octomap::OcTreeKey key = KeyAt(address);
    Node* node = CellNodeOf(key);
    LeafPlace place{kNothing, node->getValue()};
    const unsigned depth = kTreeDepth - static_cast<unsigned>(address.level());
    for (unsigned child_depth = cell_depth_ + 1; child_depth <= depth; ++child_depth) {
      const unsigned child = static_cast<unsigned>(ChildIndex(key, child_depth));
      node = tree_.GetOrMakeChild(node, child);
      if (child_depth == depth || node->getValue() == kNothing) continue;
      coarse_.push_back(node);
      leaves_.evidence(node->getValue()).hit_frame = frame_id;
    }
    if (node->getValue() == kNothing) {
      if (tree_.nodeHasChildren(node)) return place;
      node->setValue(leaves_.Take());
      Evidence& evidence = leaves_.evidence(node->getValue());
      evidence.corner = CornerInCell(address);
      evidence.level = static_cast<std::uint8_t>(address.level());
      evidence.cell = place.cell;
      std::vector<int>& in_cell = cells_[place.cell].leaves;
      const auto at =
          std::lower_bound(in_cell.begin(), in_cell.end(), Rank(evidence),
                           [&](int other, int rank) { return Rank(leaves_.evidence(other)) < rank; });
      in_cell.insert(at, node->getValue());
    }
    place.leaf = node->getValue();
    leaves_.evidence(place.leaf).alone = coarse_.empty();
    frame_leaves_.Remember(address, place);
    return place;
  }

  void AddLeaf(const FrameLeaf& seen, int index, FrameId frame_id, const Eigen::Vector3d& camera_world,
               Cell* cell) {
    Leaf& leaf = leaves_.leaf(index);
    AddToLeaf(seen, camera_world, &leaf);
    Evidence& evidence = leaves_.evidence(index);
    evidence.hit_frame = frame_id;
    evidence.credit = std::min(evidence.credit + 1, config_.free_frames);
    evidence.enough_points = leaf.moments.num_points >= static_cast<float>(config_.min_points) &&
                             leaf.num_frames >= static_cast<float>(config_.min_frames);
    // Coarse leaves, seen from afar, give way to a finer one that is well known.
    if (leaf.num_frames < kFramesToReplace) return;
    for (Node* coarse : coarse_) {
      std::erase(cell->leaves, coarse->getValue());
      leaves_.GiveBack(coarse->getValue());
      coarse->setValue(kNothing);
      ++cell->num_changed_leaves;
    }
    evidence.alone = true;
  }

  void Touch(const CellKey& key, FrameId frame_id, Cell* cell) {
    if (cell->touched_frame == frame_id) return;
    cell->touched_frame = frame_id;
    touched_.push_back(key);
  }

  void AddToLeaf(const FrameLeaf& seen, const Eigen::Vector3d& camera_world, Leaf* leaf) const {
    if (leaf->num_frames >= static_cast<float>(config_.memory_frames)) {
      const float fade = 1.0F - 1.0F / static_cast<float>(config_.memory_frames);
      leaf->moments.Scale(fade);
      leaf->view_sum *= fade;
      leaf->num_frames *= fade;
    }
    const LeafAddress& at = seen.address;
    const double half = 0.5 * (1 << at.level());
    const Eigen::Vector3d centre = config_.leaf_size_m * (Eigen::Vector3d(at.x(), at.y(), at.z()) +
                                                          Eigen::Vector3d::Constant(half - kKeyOffset));
    const Eigen::Vector3d ray = centre - camera_world;
    const float range = static_cast<float>(ray.norm());
    leaf->view_sum += seen.moments.weight / std::max(range, 1e-3F) * ray.cast<float>();
    leaf->moments.Add(seen.moments);
    leaf->num_frames += 1.0F;
    const float spacing = range / static_cast<float>(camera_.fx);
    if (leaf->spacing_m == 0.0F || spacing < leaf->spacing_m) leaf->spacing_m = spacing;
  }

  /// Walks the octree inside the field of view and clears leaves behind which the image shows something.
  void ClearFreeSpace(FrameId frame_id, const Eigen::Isometry3d& T_world_left) {
    Node* root = tree_.getRoot();
    float least = std::numeric_limits<float>::infinity();
    for (const float disparity : tile_disparity_)
      if (disparity > 0.0F) least = std::min(least, disparity);
    if (root == nullptr || !std::isfinite(least)) return;
    WidenTiles();
    frame_id_ = frame_id;
    T_left_world_ = T_world_left.inverse();
    R_left_leaves_ = (T_left_world_.linear() * config_.leaf_size_m).cast<float>();
    farthest_m_ = camera_.Depth(least);
    // Inward normals of the planes through the camera and an edge of the image.
    const double left = -camera_.cx / camera_.fx, right = (camera_.width - 1 - camera_.cx) / camera_.fx;
    const double top = -camera_.cy / camera_.fy, bottom = (camera_.height - 1 - camera_.cy) / camera_.fy;
    sides_ = {Eigen::Vector3d(1, 0, -left).normalized(), Eigen::Vector3d(-1, 0, right).normalized(),
              Eigen::Vector3d(0, 1, -top).normalized(), Eigen::Vector3d(0, -1, bottom).normalized()};
    CheckCells(root, 0, Eigen::Vector3i::Zero());
  }

  /// Each tile gets the nearest of itself and its right and lower neighbours; unknown where one of them is.
  void WidenTiles() {
    for (int y = 0; y < tiles_y_; ++y) {
      for (int x = 0; x < tiles_x_; ++x) {
        float* tile = &tile_disparity_[static_cast<std::size_t>(y) * tiles_x_ + x];
        if (x + 1 >= tiles_x_ || y + 1 >= tiles_y_) {
          *tile = 0.0F;
          continue;
        }
        const std::array<float, 4> d{tile[0], tile[1], tile[tiles_x_], tile[tiles_x_ + 1]};
        *tile = *std::min_element(d.begin(), d.end()) > 0.0F ? *std::max_element(d.begin(), d.end()) : 0.0F;
      }
    }
  }

  void CheckCells(Node* node, unsigned depth, const Eigen::Vector3i& corner) {
    const int size = 1 << (kTreeDepth - depth);
    const Eigen::Vector3d centre =
        T_left_world_ *
        (config_.leaf_size_m * (corner.cast<double>() + Eigen::Vector3d::Constant(0.5 * size - kKeyOffset)));
    const double radius = 0.5 * std::sqrt(3.0) * size * config_.leaf_size_m;
    if (centre.z() + radius <= 0.0 || centre.z() - radius > farthest_m_) return;
    for (const Eigen::Vector3d& side : sides_)
      if (side.dot(centre) < -radius) return;
    if (depth == cell_depth_) {
      const CellKey key = KeyOf(KeyAt(corner));
      // Cells take turns, so that a frame checks one in kTurns.
      if (((key.x + key.y + key.z + frame_id_) & (kTurns - 1)) != 0) return;
      Cell& cell = cells_[node->getValue()];
      const int before = cell.num_changed_leaves;
      CheckLeaves(node, corner, centre.cast<float>(), &cell);
      if (cell.num_changed_leaves != before) Touch(key, frame_id_, &cell);
      return;
    }
    for (unsigned child = 0; child < 8; ++child)
      if (tree_.nodeChildExists(node, child))
        CheckCells(tree_.getNodeChild(node, child), depth + 1, corner + size / 2 * Octant(child));
  }

  /// @param corner  lowest one of the cell
  /// @param centre  of the cell, in the left frame
  void CheckLeaves(Node* node, const Eigen::Vector3i& corner, const Eigen::Vector3f& centre, Cell* cell) {
    const Eigen::Vector3f corner_left =
        centre -
        R_left_leaves_ * Eigen::Vector3f::Constant(0.5F * static_cast<float>(config_.leaves_per_cell));
    const auto is_cleared = [&](int index) {
      Evidence& leaf = leaves_.evidence(index);
      const Eigen::Vector3i in_cell(leaf.corner[0], leaf.corner[1], leaf.corner[2]);
      if (!CheckLeaf(in_cell, corner_left, &leaf, cell)) return false;
      Remove(node, KeyAt(corner + in_cell), kTreeDepth - leaf.level);
      leaves_.GiveBack(index);
      return true;
    };
    std::erase_if(cell->leaves, is_cleared);
  }

  /// True when the leaf has been seen through too often.
  bool CheckLeaf(const Eigen::Vector3i& in_cell, const Eigen::Vector3f& corner_left, Evidence* leaf,
                 Cell* cell) const {
    const float half = 0.5F * static_cast<float>(1 << leaf->level);
    const Eigen::Vector3f centre =
        corner_left + R_left_leaves_ * (in_cell.cast<float>() + Eigen::Vector3f::Constant(half));
    const View view = ViewOf(centre, 1.74F * half * static_cast<float>(config_.leaf_size_m));
    if (view != View::kNone) {
      leaf->num_views += 1.0F;
      if (leaf->hit_frame == frame_id_) leaf->num_hits += 1.0F;
      if (leaf->num_views > static_cast<float>(config_.memory_frames)) {
        leaf->num_views *= 0.5F;
        leaf->num_hits *= 0.5F;
      }
    }
    const bool was_occupied = leaf->occupied;
    const bool cleared = view == View::kThrough && --leaf->credit < 0;
    leaf->occupied = !cleared && IsOccupied(*leaf);
    if (leaf->occupied != was_occupied) ++cell->num_changed_leaves;
    return cleared;
  }

  /// Takes a leaf out of the tree, and the nodes above it that hold nothing any more, up to the cell's.
  void Remove(Node* cell_node, const octomap::OcTreeKey& key, unsigned depth) {
    std::array<Node*, kTreeDepth + 1> path{};
    path[cell_depth_] = cell_node;
    for (unsigned d = cell_depth_; d < depth; ++d)
      path[d + 1] = tree_.getNodeChild(path[d], static_cast<unsigned>(ChildIndex(key, d + 1)));
    path[depth]->setValue(kNothing);
    for (unsigned d = depth; d > cell_depth_; --d) {
      if (path[d]->getValue() != kNothing || path[d]->HasArrayOfChildren()) return;
      tree_.deleteNodeChild(path[d - 1], static_cast<unsigned>(ChildIndex(key, d)));
      tree_.ReleaseEmptyChildren(path[d - 1]);
    }
  }

  static Eigen::Vector3i Octant(unsigned child) {
    return Eigen::Vector3i(child & 1U, (child >> 1U) & 1U, (child >> 2U) & 1U);
  }

  enum class View { kNone, kOnto, kThrough };

  /// What the image says of a place: nothing, or that something may be there, or that it looked through.
  View ViewOf(const Eigen::Vector3f& centre, float radius) const {
    if (centre.z() <= radius + 0.02F) return View::kNone;
    const float inverse_z = 1.0F / centre.z();
    // The tile whose corner towards its right and lower neighbours is nearest.
    const float u =
        (static_cast<float>(camera_.fx) * centre.x() * inverse_z + static_cast<float>(camera_.cx) + 0.5F) /
            kTilePx -
        0.5F;
    const float v =
        (static_cast<float>(camera_.fy) * centre.y() * inverse_z + static_cast<float>(camera_.cy) + 0.5F) /
            kTilePx -
        0.5F;
    if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(tiles_x_) && v < static_cast<float>(tiles_y_)))
      return View::kNone;
    const float nearest =
        tile_disparity_[static_cast<std::size_t>(v) * tiles_x_ + static_cast<std::size_t>(u)];
    if (nearest == 0.0F) return View::kNone;
    const float fb = static_cast<float>(camera_.fx * camera_.baseline_m);
    const float margin = static_cast<float>(config_.free_margin_px);
    if (fb / (centre.z() + radius) > nearest + margin) return View::kThrough;
    return nearest > fb / (centre.z() - radius) + margin ? View::kNone : View::kOnto;
  }

  /// Cells that changed a lot are worth a fit at once; small changes wait a few frames for more.
  void ReportChanged(FrameId frame_id, ChangedCells* changed) {
    for (const CellKey& key : touched_) {
      const Cell& cell = cells_[FindCell(key)->getValue()];
      const bool heavier = cell.weight > kWorthAFit * cell.fitted_weight;
      const bool old = frame_id - cell.reported_frame >= config_.memory_frames / 4;
      if (cell.num_changed_leaves > 0 || heavier || old) waiting_.insert(key);
    }
    for (auto at = waiting_.begin(); at != waiting_.end();) {
      Cell& cell = cells_[FindCell(*at)->getValue()];
      if (frame_id - cell.reported_frame < kPatience && cell.num_changed_leaves < kManyLeaves) {
        ++at;
        continue;
      }
      cell.fitted_weight = cell.weight;
      cell.num_changed_leaves = 0;
      cell.reported_frame = frame_id;
      changed->keys.push_back(*at);
      at = waiting_.erase(at);
    }
  }

  Node* CellNodeOf(const octomap::OcTreeKey& key) {
    const CellKey cell_key = KeyOf(key);
    if (last_cell_node_ != nullptr && last_cell_key_ == cell_key) return last_cell_node_;
    Node* node = tree_.MakeRoot();
    for (unsigned depth = 1; depth <= cell_depth_; ++depth) {
      const unsigned child = static_cast<unsigned>(ChildIndex(key, depth));
      node = tree_.GetOrMakeChild(node, child);
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

  bool IsOccupied(const Evidence& leaf) const {
    return leaf.enough_points && leaf.num_hits >= static_cast<float>(config_.min_hit_share) * leaf.num_views;
  }

  Surfel SurfelOf(const Leaf& leaf, const Evidence& evidence) const {
    const PointMoments& m = leaf.moments;
    const float leaf_m = static_cast<float>(config_.leaf_size_m);
    const auto size = static_cast<float>(1 << evidence.level);
    const Eigen::Vector3f in_cell(evidence.corner[0], evidence.corner[1], evidence.corner[2]);
    const Eigen::Vector3f centre =
        leaf_m *
        (in_cell + Eigen::Vector3f::Constant(0.5F * (size - static_cast<float>(config_.leaves_per_cell))));
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
    surfel.size_m = size * leaf_m;
    surfel.spacing_m = leaf.spacing_m;
    return surfel;
  }

  static constexpr float kWorthAFit = 1.2F;  // a fifth more weight
  static constexpr FrameId kPatience = 4;    // frames between two fits of a cell
  static constexpr int kManyLeaves = 12;     // that changed and make the next fit urgent
  static constexpr float kFramesToReplace = 3.0F;
  static constexpr FrameId kTurns = 2;  // a power of two

  const MappingConfig config_;
  const StereoCamera camera_;
  const int cell_shift_;
  const unsigned cell_depth_;
  const int max_level_;
  Tree tree_;
  LeafPool leaves_;
  Pool<Cell> cells_;
  FrameLeaves frame_leaves_;
  std::vector<Node*> coarse_;     // above the leaf that is being added to
  std::vector<CellKey> touched_;  // by the frame at hand, each once
  std::set<CellKey> waiting_;     // for a fit
  CellKey last_cell_key_;
  Node* last_cell_node_ = nullptr;

  // Of the frame at hand, for free space.
  const int tiles_x_;
  const int tiles_y_;
  std::vector<float> tile_disparity_;  // greatest, that is nearest, in each tile; 0 = no point
  Eigen::Isometry3d T_left_world_ = Eigen::Isometry3d::Identity();
  Eigen::Matrix3f R_left_leaves_ = Eigen::Matrix3f::Identity();  // times the size of a leaf
  std::array<Eigen::Vector3d, 4> sides_;
  double farthest_m_ = 0.0;
  FrameId frame_id_ = 0;
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
