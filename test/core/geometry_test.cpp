// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(AxesOfTest, MakeARightHandedFrameForAnyNormal) {
  for (const Eigen::Vector3d& n :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(1, 0, 0),
        Eigen::Vector3d(0.6, -0.64, 0.48), Eigen::Vector3d(0.8, 0.6, 0)}) {
    const PlaneAxes axes = AxesOf(n);
    EXPECT_NEAR(axes.x.norm(), 1.0, 1e-12);
    EXPECT_NEAR(axes.x.dot(n), 0.0, 1e-12);
    EXPECT_TRUE(axes.x.cross(axes.y).isApprox(n, 1e-12));
  }
}

TEST(SignedAreaTest, IsPositiveWhenCounterClockwiseSeenFromTheNormal) {
  // Far from the origin, where a careless sum loses the area in rounding.
  const Eigen::Vector3d o(1e6, -1e6, 1e3);
  const Ring l_shape = {o,
                        o + Eigen::Vector3d(2, 0, 0),
                        o + Eigen::Vector3d(2, 1, 0),
                        o + Eigen::Vector3d(1, 1, 0),
                        o + Eigen::Vector3d(1, 2, 0),
                        o + Eigen::Vector3d(0, 2, 0)};
  EXPECT_NEAR(SignedArea(l_shape, Eigen::Vector3d::UnitZ()), 3.0, 1e-9);
  EXPECT_NEAR(SignedArea(l_shape, -Eigen::Vector3d::UnitZ()), -3.0, 1e-9);
}

}  // namespace
}  // namespace terrace
