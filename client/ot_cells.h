// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace terrace {

/// A cube of an octree that holds something.
struct OccupiedCell {
  Eigen::Vector3i corner = Eigen::Vector3i::Zero();  ///< lowest one, in finest leaves from the origin
  int num_leaves = 1;                                ///< finest leaves along an edge
};

struct OccupiedCells {
  double leaf_m = 0.0;  ///< edge of a finest leaf
  std::vector<OccupiedCell> cells;
};

/// The leaves of an OctoMap file (`.ot` of an OcTree, as octree_v1_t carries it) that are more likely
/// occupied than free. The bytes came over a network: throws std::runtime_error with what is wrong where they
/// are no such file. Source: OctoMap 1.9, AbstractOcTree::write and OcTreeBaseImpl::writeNodesRecurs.
OccupiedCells ReadOtCells(std::span<const std::uint8_t> bytes);

}  // namespace terrace
