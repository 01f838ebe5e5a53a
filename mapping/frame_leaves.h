// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/leaf_pool.h"
#include "mapping/point_moments.h"

namespace terrace {

/// Level and lowest corner of a leaf of the octree, OctoMap's keys, in one number.
struct LeafAddress {
  std::uint64_t packed = 0;

  LeafAddress() = default;
  LeafAddress(std::uint16_t x, std::uint16_t y, std::uint16_t z, int level)
      : packed(std::uint64_t(level) << 48 | std::uint64_t(x) << 32 | std::uint64_t(y) << 16 | z) {}

  std::uint16_t x() const { return static_cast<std::uint16_t>(packed >> 32); }
  std::uint16_t y() const { return static_cast<std::uint16_t>(packed >> 16); }
  std::uint16_t z() const { return static_cast<std::uint16_t>(packed); }
  int level() const { return static_cast<int>(packed >> 48); }
  bool operator==(const LeafAddress&) const = default;
};

/// Where a leaf of the map is kept; it may have gone since.
struct LeafPlace {
  int leaf = kNothing;
  int cell = kNothing;
};

/// A leaf that a frame touches, and the frame's points in it.
struct FrameLeaf {
  LeafAddress address;
  PointMoments moments;
  LeafPlace place;  ///< where an earlier frame found it, if that is still known
};

/// The leaves that one frame touches: an open-addressing table that is emptied in no time. What earlier frames
/// left in it tells, for most leaves, where the map keeps them.
class FrameLeaves {
 public:
  /// @param width  of the image, whose points come in rows
  explicit FrameLeaves(int width)
      : slots_(std::size_t{1} << 15), above_(static_cast<std::size_t>(width / kColumn) + 1) {}

  void Clear();
  /// The leaf of this address; made when the frame has not touched it yet.
  /// @param u  column of the image: most points lie in the leaf of the one to their left or above
  FrameLeaf& At(LeafAddress address, int u);
  /// Tells later frames where the map keeps a leaf that this frame touches.
  void Remember(LeafAddress address, const LeafPlace& place) { Find(address).place = place; }

  const std::vector<FrameLeaf>& leaves() const { return leaves_; }
  std::int64_t memory_bytes() const;

 private:
  struct Slot {
    LeafAddress address;
    LeafPlace place;
    std::uint32_t generation = 0;
    std::uint32_t index = 0;
  };
  Slot& Find(LeafAddress address);
  void Grow();

  std::vector<Slot> slots_;
  std::vector<FrameLeaf> leaves_;
  std::vector<std::uint32_t> above_;  // by column: the leaf of the point last seen there
  std::uint32_t generation_ = 1;

  static constexpr int kColumn = 4;  // pixels; a leaf is seldom narrower
};

}  // namespace terrace
