// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/plane_support.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include <gmock/gmock.h>

#include "test/every_target.h"

namespace terrace {
namespace {

using ::testing::FloatNear;

constexpr InlierLimits kLimits{0.012F, 0.12F, 0.32F};

Surfel LeafAtHeight(float z) {
  Surfel leaf;
  leaf.size_m = 0.02F;
  leaf.mean = {0.0F, 0.0F, z};
  leaf.view = -Eigen::Vector3f::UnitZ();
  leaf.sigma_view_m = 0.01F;
  return leaf;
}

/// Leaves anywhere, seen from anywhere, with any noise, and planes through them.
std::pair<std::vector<Surfel>, std::vector<CellPlane>> AnyLeavesAndPlanes() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> any(-1.0F, 1.0F);
  const auto direction = [&] { return Eigen::Vector3f(any(random), any(random), any(random)).normalized(); };
  std::vector<Surfel> leaves(101);
  for (Surfel& leaf : leaves) {
    leaf.size_m = any(random) > 0.0F ? 0.02F : 0.04F;
    leaf.mean = 0.16F * Eigen::Vector3f(any(random), any(random), any(random));
    leaf.view = direction();
    leaf.sigma_view_m = 0.02F * (1.001F + any(random));
  }
  std::vector<CellPlane> planes(50);
  for (CellPlane& plane : planes) plane = {direction(), 0.1F * any(random), 1.0F};
  return {leaves, planes};
}

float ExplainedBy(const std::vector<Surfel>& leaves, CellPlane* plane) {
  std::vector<int> all(leaves.size());
  std::iota(all.begin(), all.end(), 0);
  SurfelColumns columns;
  columns.Assign(leaves, all);
  return Explained(columns, kLimits, plane);
}

/// The definition, leaf by leaf, with the true logarithm.
float SlowlyExplained(const std::vector<Surfel>& leaves, const CellPlane& plane, float scale) {
  float sum = 0.0F;
  for (const Surfel& leaf : leaves) {
    const float facing = -plane.normal.dot(leaf.view);
    const float distance = plane.normal.dot(leaf.mean) - plane.offset_m;
    const float noise = std::clamp(3.0F * leaf.sigma_view_m * facing, kLimits.least_m, kLimits.most_m);
    if (facing < kLeastFacing || std::abs(distance) >= noise) continue;
    const float allowed = std::max(scale * noise, kLimits.least_m);
    const float share = distance / allowed;
    const float support = 1.9F + 0.5F * std::log(kLimits.cell_size_m / allowed) - 4.5F * share * share;
    sum += leaf.size_m * leaf.size_m * std::max(0.0F, support);
  }
  return sum;
}

TEST(PlaneSupportTest, ExplainsWhatTheDefinitionSaysAtTheBestOfThreeScales) {
  auto [leaves, planes] = AnyLeavesAndPlanes();
  for (CellPlane& plane : planes) {
    float best = 0.0F, area = 0.0F;
    for (const float scale : {1.0F, 0.5F, 0.25F})
      best = std::max(best, SlowlyExplained(leaves, plane, scale));
    for (const Surfel& leaf : leaves) area += leaf.size_m * leaf.size_m;
    // The logarithm is good to 0.06, half of which counts, for each leaf.
    EXPECT_THAT(ExplainedBy(leaves, &plane), FloatNear(best, 0.03F * area));
  }
}

TEST(PlaneSupportTest, GivesTheSameBitsOnEveryInstructionSet) {
  const auto [leaves, planes] = AnyLeavesAndPlanes();
  std::vector<std::pair<float, float>> expected;
  for (CellPlane plane : planes) {
    const float explained = ExplainedBy(leaves, &plane);
    expected.emplace_back(explained, plane.scale);
  }
  OnEveryTarget([&, &all_leaves = leaves, &all_planes = planes] {
    for (std::size_t i = 0; i < all_planes.size(); ++i) {
      CellPlane plane = all_planes[i];
      const float explained = ExplainedBy(all_leaves, &plane);
      EXPECT_EQ(std::pair(explained, plane.scale), expected[i]) << i;
    }
  });
}

TEST(PlaneSupportTest, TakesTheTightestScaleThatHoldsTheLeaves) {
  CellPlane plane;
  ExplainedBy({LeafAtHeight(0.0005F), LeafAtHeight(-0.0005F), LeafAtHeight(0.0F)}, &plane);
  EXPECT_EQ(plane.scale, 0.25F);
  ExplainedBy({LeafAtHeight(0.014F), LeafAtHeight(-0.014F), LeafAtHeight(0.012F)}, &plane);
  EXPECT_EQ(plane.scale, 1.0F);
}

TEST(PlaneSupportTest, DoesNotCountLeavesSeenFromBehindOrFarFromThePlane) {
  Surfel behind = LeafAtHeight(0.0F), far = LeafAtHeight(0.031F);
  behind.view = Eigen::Vector3f::UnitZ();
  CellPlane plane;
  EXPECT_EQ(ExplainedBy({behind, far}, &plane), 0.0F);
  EXPECT_GT(ExplainedBy({behind, far, LeafAtHeight(0.0F)}, &plane), 0.0F);
}

}  // namespace
}  // namespace terrace
