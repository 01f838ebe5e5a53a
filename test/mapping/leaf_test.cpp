// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/leaf.h"

#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace terrace {
namespace {

/// The same with sums in double precision.
struct PlainSums {
  double weight = 0.0, num_points = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();

  void Fade(double factor) {
    weight *= factor;
    num_points *= factor;
    sum *= factor;
    outer *= factor;
  }
  void Add(double w, const Eigen::Vector3d& p) {
    weight += w;
    num_points += 1.0;
    sum += w * p;
    outer += w * p * p.transpose();
  }
  Eigen::Vector3d Mean() const { return sum / weight; }
  Eigen::Matrix3d Covariance() const { return outer / weight - Mean() * Mean().transpose(); }
};

class LeafTest : public testing::TestWithParam<float> {};

TEST_P(LeafTest, KnowsWhatSumsOverAllItsPointsWouldSay) {
  const float edge_m = GetParam();
  const double noise_m = 0.05 * edge_m;
  std::mt19937 random(101);
  std::uniform_real_distribution<double> across(-0.5 * edge_m, 0.5 * edge_m);
  std::normal_distribution<double> noise(0.0, noise_m);
  Leaf leaf;
  PlainSums plain;
  for (int frame = 0; frame < 300; ++frame) {
    if (frame >= 60) {
      leaf.Fade(1.0F - 1.0F / 60.0F);
      plain.Fade(1.0 - 1.0 / 60.0);
    }
    PointMoments points;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d p(across(random), across(random), 0.1 * edge_m + noise(random));
      const double weight = (1.0 + 0.5 * i) / (noise_m * noise_m);
      points.Add(static_cast<float>(weight), p.cast<float>());
      plain.Add(weight, p);
    }
    leaf.Add(points, -Eigen::Vector3f::UnitZ(), edge_m);
  }
  EXPECT_NEAR(leaf.weight / plain.weight, 1.0, 1e-3);
  EXPECT_NEAR(leaf.num_points(), plain.num_points, 0.01 * plain.num_points);
  const Eigen::Vector3d mean_error = leaf.Mean_m(edge_m).cast<double>() - plain.Mean();
  EXPECT_LT(mean_error.norm(), 0.01 * noise_m);
  const Eigen::Matrix3d covariance_error = leaf.Covariance_m2(edge_m).cast<double>() - plain.Covariance();
  EXPECT_LT(covariance_error.cwiseAbs().maxCoeff(), 0.02 * noise_m * noise_m);
  EXPECT_LT((leaf.View() + Eigen::Vector3f::UnitZ()).norm(), 1e-6F);
}

INSTANTIATE_TEST_SUITE_P(FineAndCoarse, LeafTest, testing::Values(0.02F, 0.08F));

TEST(LeafTest, SeesAlongTheMiddleOfItsViews) {
  Leaf leaf;
  PointMoments points;
  points.Add(1.0F, {0.001F, 0.002F, 0.003F});
  leaf.Add(points, Eigen::Vector3f::UnitX(), 0.02F);
  leaf.Add(points, Eigen::Vector3f::UnitY(), 0.02F);
  EXPECT_LT((leaf.View() - Eigen::Vector3f(1.0F, 1.0F, 0.0F).normalized()).norm(), 1e-4F);
}

TEST(LeafTest, TellsTheMeanVarianceOfMorePointsThanItCanCount) {
  Leaf leaf;
  for (int frame = 0; frame < 200; ++frame) {
    PointMoments points;
    for (int i = 0; i < 100; ++i) points.Add(4.0F, {0.0F, 0.0F, 0.0F});
    leaf.Add(points, Eigen::Vector3f::UnitX(), 0.02F);
  }
  EXPECT_GT(leaf.num_points(), 8000.0F);
  EXPECT_NEAR(leaf.num_points() / leaf.weight, 0.25F, 1e-3F);
}

}  // namespace
}  // namespace terrace
