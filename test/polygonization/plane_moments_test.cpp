// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_moments.h"

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "core/geometry.h"

namespace terrace {
namespace {

const Eigen::Vector3d kTiltedNormal = Eigen::Vector3d(0.2, -0.3, 1.0).normalized();
constexpr double kTiltedOffset_m = 0.7;

/// Points of the plane of kTiltedNormal, moved along the normal by even noise of this standard deviation.
std::vector<Eigen::Vector3d> PointsOfTiltedPlane(int num, double noise_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  const PlaneAxes axes = AxesOf(kTiltedNormal);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < num; ++i) {
    const double along_m = kTiltedOffset_m + std::sqrt(3.0) * noise_m * even(random);
    points.push_back(along_m * kTiltedNormal + even(random) * axes.x + 0.5 * even(random) * axes.y);
  }
  return points;
}

PlaneMoments MomentsOf(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin) {
  PlaneMoments moments;
  for (const Eigen::Vector3d& p : points) moments.Add(1.0, p - origin);
  return moments;
}

TEST(PlaneMomentsTest, FindsThePlaneOfPointsThatLieInOne) {
  const PlaneMoments moments = MomentsOf(PointsOfTiltedPlane(50, 0.0, 1), Eigen::Vector3d::Zero());
  const Plane plane = moments.Fit(Eigen::Vector3d::UnitZ());
  EXPECT_LT((plane.normal - kTiltedNormal).norm(), 1e-9);
  EXPECT_NEAR(plane.offset_m, kTiltedOffset_m, 1e-9);
  EXPECT_NEAR(moments.MeanSquaredDistance(plane), 0.0, 1e-12);
}

TEST(PlaneMomentsTest, TurnsTheNormalToTheSideThatIsAskedFor) {
  const PlaneMoments moments = MomentsOf(PointsOfTiltedPlane(50, 0.0, 1), Eigen::Vector3d::Zero());
  const Plane down = moments.Fit(-Eigen::Vector3d::UnitZ());
  EXPECT_LT((down.normal + kTiltedNormal).norm(), 1e-9);
  EXPECT_NEAR(down.offset_m, -kTiltedOffset_m, 1e-9);
}

TEST(PlaneMomentsTest, SumsOfSumsSayTheSameAsAllPointsAtOnce) {
  const std::vector<Eigen::Vector3d> points = PointsOfTiltedPlane(200, 0.01, 2);
  const Eigen::Vector3d origin(0.3, -0.2, 0.5), far_origin(4.0, -7.0, 2.0);
  PlaneMoments whole;
  for (int part = 0; part < 4; ++part) {
    const std::vector<Eigen::Vector3d> some(points.begin() + 50 * part, points.begin() + 50 * (part + 1));
    const Eigen::Vector3d own_origin = part % 2 == 0 ? origin : far_origin;
    whole.Add(MomentsOf(some, own_origin), own_origin - origin);
  }
  const PlaneMoments at_once = MomentsOf(points, origin);
  constexpr double kRounding = 1e-9;  // of sums about an origin that is metres away
  EXPECT_DOUBLE_EQ(whole.weight, at_once.weight);
  EXPECT_LT((whole.Mean() - at_once.Mean()).norm(), kRounding);
  EXPECT_LT((whole.Covariance() - at_once.Covariance()).norm(), kRounding);
}

TEST(PlaneMomentsTest, HeedsWhatIsCertainMoreThanWhatIsNot) {
  // A certain plane at height 0 and an uncertain one a decimetre above it.
  PlaneMoments moments;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      moments.Add(9.0, {x, y, 0.0});
      moments.Add(1.0, {x, y, 0.1});
    }
  }
  const Plane plane = moments.Fit(Eigen::Vector3d::UnitZ());
  EXPECT_LT((plane.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_NEAR(plane.offset_m, 0.01, 1e-12);  // (9 * 0 + 1 * 0.1) / 10
}

TEST(PlaneMomentsTest, MeasuresTheScatterAboutThePlaneAndAboutOneBesideIt) {
  constexpr double kNoise_m = 0.01;
  const PlaneMoments moments = MomentsOf(PointsOfTiltedPlane(4000, kNoise_m, 3), Eigen::Vector3d::Zero());
  const double about_own = moments.MeanSquaredDistance(moments.Fit(Eigen::Vector3d::UnitZ()));
  EXPECT_NEAR(std::sqrt(about_own), kNoise_m, 0.05 * kNoise_m);
  const Plane beside{kTiltedNormal, kTiltedOffset_m + 0.03};
  EXPECT_NEAR(std::sqrt(moments.MeanSquaredDistance(beside)), std::hypot(kNoise_m, 0.03), 0.001);
}

}  // namespace
}  // namespace terrace
