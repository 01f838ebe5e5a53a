// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/frame_leaves.h"

#include <algorithm>

namespace terrace {

void FrameLeaves::Clear(int width) {
  leaves_.clear();
  last_ = 0;
  above_.assign(static_cast<std::size_t>(width / kColumn) + 1, 0);
  ++generation_;
}

FrameLeaf& FrameLeaves::At(LeafAddress address, int u) {
  std::uint32_t& above = above_[static_cast<std::size_t>(u / kColumn)];
  if (above < leaves_.size() && leaves_[above].address == address) return leaves_[last_ = above];
  if (last_ < leaves_.size() && leaves_[last_].address == address) return leaves_[above = last_];
  if (leaves_.size() * 2 >= slots_.size()) Grow();
  Slot& slot = Find(address);
  if (slot.generation != generation_) {
    const LeafPlace place = slot.address == address ? slot.place : LeafPlace{};
    slot = {address, place, generation_, static_cast<std::uint32_t>(leaves_.size())};
    leaves_.push_back({address, {}, place});
  }
  above = last_ = slot.index;
  return leaves_[slot.index];
}

std::int64_t FrameLeaves::memory_bytes() const {
  return static_cast<std::int64_t>(slots_.capacity() * sizeof(Slot) + leaves_.capacity() * sizeof(FrameLeaf) +
                                   above_.capacity() * sizeof(std::uint32_t));
}

/// A leaf's slot is one of a few beside each other, so that several leaves of earlier frames are remembered
/// beside those of this one; the oldest gives way. Only where all are taken by this frame the next few are
/// asked.
FrameLeaves::Slot& FrameLeaves::Find(LeafAddress address) {
  std::size_t at = FirstSlot(address);
  while (true) {
    Slot* const slots = &slots_[at];
    Slot* oldest = slots;
    for (Slot* slot = slots; slot != slots + kWays; ++slot) {
      if (slot->address == address) return *slot;
      if (slot->generation < oldest->generation) oldest = slot;
    }
    if (oldest->generation != generation_) return *oldest;
    at = (at + kWays) & (slots_.size() - kWays);
  }
}

void FrameLeaves::Grow() {
  std::vector<Slot> old(slots_.size() * 2);
  old.swap(slots_);
  for (const Slot& slot : old)
    if (slot.generation == generation_) Find(slot.address) = slot;
}

}  // namespace terrace
