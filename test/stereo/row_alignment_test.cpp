// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/row_alignment.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "textured_pair.h"

namespace terrace {
namespace {

constexpr double kDegree = M_PI / 180.0;
const StereoCamera kCamera{480, 360, 300, 300, 239.5, 179.5, 0.12};

/// What is wrong with the right camera.
struct Fault {
  double shift_px = 0.0;
  double roll_deg = 0.0;
  double scale = 1.0;
};

/// A floor and a wall behind it, seen by an ideal left camera and a faulty right one.
StereoFrame RenderFaulty(const Fault& fault, unsigned seed) {
  const WaveTexture texture(seed);
  const auto grey = [&](const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) {
    const double to_wall = 2.6 / ray.z();
    const double to_floor = ray.y() > 0.0 ? 0.5 / ray.y() : 1e9;
    const Eigen::Vector3d p = eye + std::min(to_wall, to_floor) * ray;
    constexpr double kWavesPerMetre = 90.0;
    const bool wall = to_wall < to_floor;
    return std::clamp(125.0 + 35.0 * texture(kWavesPerMetre * p.x(), kWavesPerMetre * (wall ? p.y() : p.z())),
                      0.0, 255.0);
  };
  StereoFrame frame;
  frame.left.create(kCamera.height, kCamera.width);
  frame.right.create(kCamera.height, kCamera.width);
  const double c = std::cos(fault.roll_deg * kDegree), s = std::sin(fault.roll_deg * kDegree);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const double x = (u - kCamera.cx) / kCamera.fx, y = (v - kCamera.cy) / kCamera.fy;
      frame.left(v, u) = static_cast<std::uint8_t>(grey({0, 0, 0}, {x, y, 1}) + 0.5);
      // From the faulty pixel back to the ideal one: lower, larger, turned clockwise.
      const double xs = x / fault.scale, ys = (y - fault.shift_px / kCamera.fy) / fault.scale;
      const Eigen::Vector3d ray(c * xs + s * ys, -s * xs + c * ys, 1);
      frame.right(v, u) = static_cast<std::uint8_t>(grey({kCamera.baseline_m, 0, 0}, ray) + 0.5);
    }
  }
  return frame;
}

RowAlignment Estimate(const Fault& fault, unsigned seed) {
  return EstimateRowAlignment(MatchAcrossRows(RenderFaulty(fault, seed)), kCamera);
}

TEST(RowAlignmentTest, FindsNothingWhereNothingIsWrong) {
  const RowAlignment found = Estimate({}, 3);
  EXPECT_GT(found.num_matches, 100);
  EXPECT_LT(found.median_px, 0.05);
  EXPECT_NEAR(found.row_shift_px, 0.0, 0.02);
  EXPECT_NEAR(found.roll_rad / kDegree, 0.0, 0.01);
  EXPECT_NEAR(found.focal_ratio, 1.0, 2e-4);
}

TEST(RowAlignmentTest, MeasuresShiftedRows) {
  for (const double shift_px : {0.2, 0.7, -2.0, 6.0}) {
    const RowAlignment found = Estimate({.shift_px = shift_px}, 4);
    EXPECT_NEAR(found.row_shift_px, shift_px, std::max(0.1 * std::abs(shift_px), 0.05)) << shift_px;
    EXPECT_NEAR(found.median_px, std::abs(shift_px), 0.1);
    EXPECT_LT(found.left_over_px, 0.05);
    EXPECT_NEAR(found.roll_rad / kDegree, 0.0, 0.02);
  }
}

TEST(RowAlignmentTest, MeasuresARolledCamera) {
  for (const double roll_deg : {0.05, -0.2, 0.5, 1.0}) {
    const RowAlignment found = Estimate({.roll_deg = roll_deg}, 5);
    EXPECT_NEAR(found.roll_rad / kDegree, roll_deg, std::max(0.1 * std::abs(roll_deg), 0.02)) << roll_deg;
    EXPECT_NEAR(found.row_shift_px, 0.0, 0.05) << roll_deg;
    EXPECT_LT(found.left_over_px, 0.06);
  }
}

TEST(RowAlignmentTest, MeasuresADifferentFocalLength) {
  const RowAlignment found = Estimate({.scale = 1.01}, 6);
  EXPECT_NEAR(found.focal_ratio, 1.01, 0.001);
}

TEST(RowAlignmentTest, MeasuresAllAtOnce) {
  const RowAlignment found = Estimate({.shift_px = 1.5, .roll_deg = 0.4, .scale = 0.995}, 7);
  EXPECT_NEAR(found.row_shift_px, 1.5, 0.15);
  EXPECT_NEAR(found.roll_rad / kDegree, 0.4, 0.04);
  // As sure as it says.
  EXPECT_NEAR(found.row_shift_px, 1.5, 3.0 * found.row_shift_sigma_px);
  EXPECT_NEAR(found.roll_rad, 0.4 * kDegree, 3.0 * found.roll_sigma_rad);
  EXPECT_NEAR(found.focal_ratio, 0.995, 3.0 * found.focal_ratio_sigma);
  EXPECT_NEAR(found.focal_ratio, 0.995, 0.001);
}

TEST(RowAlignmentTest, SaysHowManyMatchesWereTooFew) {
  const RowAlignment found = EstimateRowAlignment({{{1, 2}, {0, 5}}}, kCamera);
  EXPECT_EQ(found.num_matches, 1);
  EXPECT_EQ(found.roll_rad, 0.0);
}

}  // namespace
}  // namespace terrace
