// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/octomap_bytes.h"

#include <algorithm>
#include <sstream>
#include <string>
#include <tuple>

#include <octomap/OcTree.h>

namespace terrace {
namespace {

constexpr int kOctomapDepth = 16;

bool HasKey(const OccupiedLeaf& leaf) {
  return leaf.corner.minCoeff() >= -kOctomapReachLeaves &&
         leaf.corner.maxCoeff() + (1 << leaf.level) <= kOctomapReachLeaves;
}

/// OctoMap's tree, filled from coarse to fine with leaves at their own depth.
class FilledTree : public octomap::OcTree {
 public:
  explicit FilledTree(double leaf_size_m) : octomap::OcTree(leaf_size_m) {}

  void Fill(const OccupiedLeaf& leaf) {
    bool is_new = root == nullptr;
    if (is_new) {
      root = new octomap::OcTreeNode();  // owned and deleted by the base class
      ++tree_size;
    }
    octomap::OcTreeNode* node = root;
    for (int level = kOctomapDepth - 1; level >= leaf.level; --level) {
      // A node without children that was there before is an earlier, coarser leaf, occupied as a whole.
      if (!is_new && !nodeHasChildren(node)) expandNode(node);
      const unsigned child = ChildIndex(leaf.corner, level);
      is_new = !nodeChildExists(node, child);
      node = is_new ? createNodeChild(node, child) : getNodeChild(node, child);
    }
    node->setLogOdds(std::min(static_cast<float>(leaf.num_hits) * getProbHitLog(), getClampingThresMaxLog()));
  }

 private:
  static unsigned ChildIndex(const LeafIndex& corner, int level) {
    unsigned child = 0;
    for (int axis = 0; axis < 3; ++axis) child |= (unsigned{KeyOf(corner[axis])} >> level & 1U) << axis;
    return child;
  }
};

}  // namespace

std::vector<std::uint8_t> OctomapBytes(std::vector<OccupiedLeaf> leaves, double leaf_size_m,
                                       OctomapFormat format) {
  std::erase_if(leaves, [](const OccupiedLeaf& leaf) { return !HasKey(leaf); });
  std::sort(leaves.begin(), leaves.end(), [](const OccupiedLeaf& a, const OccupiedLeaf& b) {
    return std::tuple(-a.level, a.corner.x(), a.corner.y(), a.corner.z()) <
           std::tuple(-b.level, b.corner.x(), b.corner.y(), b.corner.z());
  });
  FilledTree tree(leaf_size_m);
  for (const OccupiedLeaf& leaf : leaves) tree.Fill(leaf);
  std::ostringstream out;
  if (tree.size() > 0) tree.updateInnerOccupancy();
  if (format == OctomapFormat::kOt) {
    tree.write(out);
  } else {
    // As OcTree::writeBinary(), which also talks on the standard output.
    tree.toMaxLikelihood();
    tree.prune();
    out << "# Octomap OcTree binary file\n#\nid OcTree\nsize " << tree.size() << "\nres "
        << tree.getResolution() << "\ndata\n";
    tree.writeBinaryData(out);
  }
  const std::string bytes = out.str();
  return {bytes.begin(), bytes.end()};
}

}  // namespace terrace
