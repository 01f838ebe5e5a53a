// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry.h"

#include <random>

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

TEST(GeometryTest, KeepsCanonicalRotationsBitForBitThroughAnyNumberOfConversions) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20000; ++i) {
    Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
    if (i % 3 == 0) q = Eigen::Quaterniond(1.0, 1e-9 * normal(random), 0.0, 1e-3 * normal(random));
    if (i % 7 == 0) q = Eigen::Quaterniond(0.5, i % 2 ? 0.5 : -0.5, 0.5, -0.5);
    const Eigen::Matrix3d rotation = q.normalized().toRotationMatrix();
    const Eigen::Quaterniond once = CanonicalQuaternion(rotation);
    const Eigen::Matrix3d canonical = once.toRotationMatrix();
    // As a reader of messages does it.
    const Eigen::Quaterniond twice = CanonicalQuaternion(once.normalized().toRotationMatrix());
    ASSERT_EQ(twice.coeffs(), once.coeffs()) << i;
    ASSERT_EQ(CanonicalQuaternion(canonical).toRotationMatrix(), canonical) << i;
    ASSERT_LT((canonical - rotation).norm(), 1e-12) << i;
  }
}

}  // namespace
}  // namespace terrace
