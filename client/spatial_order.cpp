// SPDX-License-Identifier: BSD-3-Clause
#include "client/spatial_order.h"

#include <algorithm>

namespace terrace {
namespace {

/// The lower ten bits, two empty ones between each.
std::uint32_t Spread(std::uint32_t x) {
  x = (x | (x << 16)) & 0x030000ff;
  x = (x | (x << 8)) & 0x0300f00f;
  x = (x | (x << 4)) & 0x030c30c3;
  x = (x | (x << 2)) & 0x09249249;
  return x;
}

}  // namespace

std::vector<std::uint32_t> SpatialOrder(const std::vector<Eigen::AlignedBox3d>& boxes) {
  Eigen::AlignedBox3d all;
  for (const auto& box : boxes) all.extend(box);
  constexpr double kCells = 1024.0;
  const double extent_m = boxes.empty() ? 1.0 : std::max(1e-6, all.sizes().maxCoeff());
  std::vector<std::uint64_t> keys(boxes.size());  // place, then index
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const Eigen::Vector3d cell = (boxes[i].center() - all.min()) * ((kCells - 1.0) / extent_m);
    const std::uint32_t place = Spread(static_cast<std::uint32_t>(cell.x())) |
                                Spread(static_cast<std::uint32_t>(cell.y())) << 1 |
                                Spread(static_cast<std::uint32_t>(cell.z())) << 2;
    keys[i] = std::uint64_t{place} << 32 | i;
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(boxes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(keys[i]);
  return order;
}

}  // namespace terrace
