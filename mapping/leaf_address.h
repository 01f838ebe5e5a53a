// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <compare>
#include <cstdint>

#include <Eigen/Core>

namespace terrace {

/// Number of a finest leaf along each axis, counted from the world's origin.
using LeafIndex = Eigen::Vector3i;

/// OctoMap's keys have 16 bits. They are taken as the lowest bits of an index, so that the world has no end:
/// leaves that are 65,536 apart share a key, and the octree never holds both, since it forgets what is far
/// away.
constexpr int kKeyOffset = 1 << 15;
/// How far from the camera a leaf may lie, in finest leaves, so that its key means one place.
constexpr int kMaxReachLeaves = 1 << 14;

inline std::uint16_t KeyOf(int index) { return static_cast<std::uint16_t>(index + kKeyOffset); }
/// The index with this key that lies nearest to `near`.
inline int IndexOf(std::uint16_t key, int near) {
  return near + static_cast<std::int16_t>(static_cast<std::uint16_t>(key - KeyOf(near)));
}

/// Level of the coarsest leaves: at least four lie along the edge of a cell.
/// @param leaves_per_cell  a power of two
constexpr int CoarsestLevel(int leaves_per_cell) {
  return std::countr_zero(static_cast<unsigned>(leaves_per_cell)) - 2;
}

/// Level and lowest corner of a leaf of the octree, OctoMap's keys, in one number.
struct LeafAddress {
  std::uint64_t packed = 0;

  LeafAddress() = default;
  LeafAddress(std::uint16_t x, std::uint16_t y, std::uint16_t z, int level)
      : packed(std::uint64_t(level) << 48 | std::uint64_t(x) << 32 | std::uint64_t(y) << 16 | z) {}
  LeafAddress(const LeafIndex& corner, int level)
      : LeafAddress(KeyOf(corner.x()), KeyOf(corner.y()), KeyOf(corner.z()), level) {}

  std::uint16_t x() const { return static_cast<std::uint16_t>(packed >> 32); }
  std::uint16_t y() const { return static_cast<std::uint16_t>(packed >> 16); }
  std::uint16_t z() const { return static_cast<std::uint16_t>(packed); }
  int level() const { return static_cast<int>(packed >> 48); }
  /// Its lowest corner, where that is nearest to `near`.
  LeafIndex Corner(const LeafIndex& near) const {
    return {IndexOf(x(), near.x()), IndexOf(y(), near.y()), IndexOf(z(), near.z())};
  }
  bool operator==(const LeafAddress&) const = default;
};

/// Address of a cell: the octree node of `cell_size_m` that holds it, counted from the world's origin.
struct CellKey {
  int x = 0, y = 0, z = 0;
  friend constexpr auto operator<=>(const CellKey&, const CellKey&) = default;
};

}  // namespace terrace
