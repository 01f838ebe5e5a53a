// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "mapping/leaf.h"

namespace terrace {

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
  /// Slots in use and free ones.
  int num_slots() const { return static_cast<int>(items_.size()); }
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
    SetOccupied(index, false);
    evidence_[index].cell = kNothing;
    leaves_.GiveBack(index);
  }
  /// The only way in which leaves become occupied, or no longer are.
  void SetOccupied(int index, bool occupied) {
    Evidence& evidence = evidence_[index];
    num_occupied_ += int{occupied} - int{evidence.occupied};
    evidence.occupied = occupied & 1;
  }
  Leaf& leaf(int index) { return leaves_[index]; }
  const Leaf& leaf(int index) const { return leaves_[index]; }
  Evidence& evidence(int index) { return evidence_[index]; }
  const Evidence& evidence(int index) const { return evidence_[index]; }
  /// Visits leaves that lie scattered over memory, which is asked for those to come.
  template <typename Use>
  void ForEach(const std::vector<int>& indices, const Use& use) const {
    constexpr std::size_t kAhead = 8;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (i + kAhead < indices.size()) Prefetch(indices[i + kAhead]);
      use(indices[i]);
    }
  }
  /// Has both parts of a leaf fetched from memory while other work goes on.
  void Prefetch(int index) const {
    __builtin_prefetch(&leaves_[index]);
    PrefetchEvidence(index);
  }
  void PrefetchEvidence(int index) const { __builtin_prefetch(&evidence_[index]); }
  std::int64_t num_used() const { return leaves_.num_used(); }
  std::int64_t num_occupied() const { return num_occupied_; }
  std::int64_t memory_bytes() const { return leaves_.memory_bytes() + evidence_.memory_bytes(); }

 private:
  Pool<Leaf> leaves_;
  Chunks<Evidence> evidence_;
  std::int64_t num_occupied_ = 0;
};

}  // namespace terrace
