// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

namespace terrace {

/// The boxes in the order of a curve through space (Morton's: G. M. Morton, IBM, 1966), so that what is near
/// in space is near in the order.
std::vector<std::uint32_t> SpatialOrder(const std::vector<Eigen::AlignedBox3d>& boxes);

}  // namespace terrace
