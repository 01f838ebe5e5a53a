// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/leaf_address.h"

namespace terrace {

/// A place of the octree where there is something.
struct OccupiedLeaf {
  LeafIndex corner = LeafIndex::Zero();  ///< lowest one, in finest leaves from the world's origin
  int level = 0;     ///< its edge is 1 << level finest leaves; the corner is a multiple of it
  int num_hits = 1;  ///< frames that speak for it, less those that speak against it; at least 1
};

enum class OctomapFormat {
  kOt,  ///< with the probability of every leaf
  kBt,  ///< occupied or not, smaller
};

/// OctoMap has no keys for leaves farther from the origin than this, in finest leaves, along any axis.
constexpr int kOctomapReachLeaves = 1 << 15;

/// The file that OctoMap's own programs read, with these leaves and nothing else: what is not in it is free
/// or unknown. A leaf is as probable as OctoMap would have it after as many hits. Where a coarse leaf holds
/// finer ones, all of the coarse one is occupied.
/// @param leaves  in any order; those that OctoMap has no keys for are left out
std::vector<std::uint8_t> OctomapBytes(std::vector<OccupiedLeaf> leaves, double leaf_size_m,
                                       OctomapFormat format);

}  // namespace terrace
