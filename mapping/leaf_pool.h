// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/time.h"
#include "mapping/point_moments.h"

namespace terrace {

constexpr int kNothing = -1;  ///< instead of an index

/// What is known of the surface in a leaf: a cache line.
struct alignas(64) Leaf {
  PointMoments moments;
  Eigen::Vector3f view_sum = Eigen::Vector3f::Zero();  ///< weight * unit direction of view
  float num_frames = 0.0F;                             ///< that put points into it
  float spacing_m = 0.0F;
};
static_assert(sizeof(Leaf) == 64);

/// Whether a leaf is occupied, and what says so. Apart from the surface, since every frame checks many leaves
/// that it adds nothing to.
struct Evidence {
  std::array<std::uint8_t, 3> corner{};  ///< lowest one, from that of the cell, in finest leaves
  std::uint8_t level = 0;
  int cell = kNothing;  ///< that holds the leaf; kNothing when the leaf is gone
  /// Frames that had the leaf in view, nothing in front of it, when its turn came to be checked; and those of
  /// them that put points into it.
  float num_views = 0.0F;
  float num_hits = 0.0F;
  FrameId hit_frame = -1;
  int credit = 0;  ///< frames that hit it minus frames that saw through it; cleared below zero
  bool enough_points = false;
  bool occupied = false;
  bool alone = false;  ///< without a coarser leaf above it; none comes while it is there
};
static_assert(sizeof(Evidence) == 32);

/// A row of items that grows by pieces: what is in it stays where it is, and no room is kept for twice as
/// many.
template <typename T>
class Chunks {
 public:
  void Grow() {
    if (size_ == chunks_.size() * kChunk) chunks_.push_back(std::make_unique<std::array<T, kChunk>>());
    ++size_;
  }
  std::size_t size() const { return size_; }
  T& operator[](int index) { return (*chunks_[Chunk(index)])[InChunk(index)]; }
  const T& operator[](int index) const { return (*chunks_[Chunk(index)])[InChunk(index)]; }
  std::int64_t memory_bytes() const {
    return static_cast<std::int64_t>(chunks_.size() * kChunk * sizeof(T) +
                                     chunks_.capacity() * sizeof(chunks_.front()));
  }

 private:
  static constexpr std::size_t kChunk = 1024;
  static std::size_t Chunk(int index) { return static_cast<std::size_t>(index) / kChunk; }
  static std::size_t InChunk(int index) { return static_cast<std::size_t>(index) % kChunk; }

  std::vector<std::unique_ptr<std::array<T, kChunk>>> chunks_;
  std::size_t size_ = 0;
};

/// Slots that are used again, addressed by index.
template <typename T>
class Pool {
 public:
  /// An item as it is by default.
  int Take() {
    if (!free_.empty()) {
      const int index = free_.back();
      free_.pop_back();
      return index;
    }
    items_.Grow();
    return static_cast<int>(items_.size()) - 1;
  }
  void GiveBack(int index) {
    items_[index] = T{};
    free_.push_back(index);
  }
  T& operator[](int index) { return items_[index]; }
  const T& operator[](int index) const { return items_[index]; }
  std::int64_t num_used() const { return static_cast<std::int64_t>(items_.size() - free_.size()); }
  std::int64_t memory_bytes() const {
    return items_.memory_bytes() + static_cast<std::int64_t>(free_.capacity() * sizeof(int));
  }

 private:
  Chunks<T> items_;
  std::vector<int> free_;
};

/// Both parts of the leaves, by the same index.
class LeafPool {
 public:
  int Take() {
    const int index = leaves_.Take();
    if (static_cast<std::size_t>(index) == evidence_.size()) evidence_.Grow();
    evidence_[index] = {};
    return index;
  }
  void GiveBack(int index) {
    evidence_[index].cell = kNothing;
    leaves_.GiveBack(index);
  }
  Leaf& leaf(int index) { return leaves_[index]; }
  const Leaf& leaf(int index) const { return leaves_[index]; }
  Evidence& evidence(int index) { return evidence_[index]; }
  const Evidence& evidence(int index) const { return evidence_[index]; }
  /// Has both parts of a leaf fetched from memory while other work goes on.
  void Prefetch(int index) const {
    __builtin_prefetch(&leaves_[index]);
    __builtin_prefetch(&evidence_[index]);
  }
  std::int64_t num_used() const { return leaves_.num_used(); }
  std::int64_t memory_bytes() const { return leaves_.memory_bytes() + evidence_.memory_bytes(); }

 private:
  Pool<Leaf> leaves_;
  Chunks<Evidence> evidence_;
};

}  // namespace terrace
