// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/leaf_address.h"
#include "mapping/leaf_pool.h"
#include "mapping/point_moments.h"

namespace terrace {

/// Where a leaf of the map is kept; it may have gone since.
struct LeafPlace {
  int leaf = kNothing;
  int cell = kNothing;
  bool operator==(const LeafPlace&) const = default;
};

/// A leaf that a frame touches, and the frame's points in it.
struct FrameLeaf {
  LeafAddress address;
  PointMoments moments;
  LeafPlace place;  ///< where an earlier frame found it, if that is still known
};

/// The leaves that one frame touches: an open-addressing table that is emptied in no time. What earlier
/// frames left in it tells, for most leaves, where the map keeps them.
class FrameLeaves {
 public:
  FrameLeaves() : slots_(std::size_t{1} << 15) {}

  /// Begins a frame.
  /// @param width  of the image, whose points come in rows
  void Clear(int width);
  /// The leaf of this address; made when the frame has not touched it yet.
  /// @param u  column of the image: most points lie in the leaf of the one to their left or above
  FrameLeaf& At(LeafAddress address, int u);
  /// Has what At() will need fetched from memory while other work goes on.
  void Prefetch(LeafAddress address) const { __builtin_prefetch(&slots_[FirstSlot(address)]); }
  /// Tells later frames where the map keeps a leaf that this frame touches.
  void Remember(LeafAddress address, const LeafPlace& place) { Find(address).place = place; }

  const std::vector<FrameLeaf>& leaves() const { return leaves_; }
  std::int64_t memory_bytes() const;

 private:
  static constexpr std::size_t kWays = 4;  // slots that a leaf may have
  struct Slot {
    LeafAddress address;
    LeafPlace place;
    std::uint32_t generation = 0;
    std::uint32_t index = 0;
  };
  std::size_t FirstSlot(LeafAddress address) const {
    return (address.packed * 0x9E3779B97F4A7C15ULL) >> 20 & (slots_.size() - kWays);
  }
  Slot& Find(LeafAddress address);
  void Grow();

  std::vector<Slot> slots_;
  std::vector<FrameLeaf> leaves_;
  std::vector<std::uint32_t> above_;  // by column: the leaf of the point last seen there
  std::uint32_t last_ = 0;            // of the point before
  std::uint32_t generation_ = 1;

  static constexpr int kColumn = 4;  // pixels; a leaf is seldom narrower
};

}  // namespace terrace
