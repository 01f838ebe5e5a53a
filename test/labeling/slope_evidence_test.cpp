// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/slope_evidence.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "label_scene.h"

namespace terrace {
namespace {

/// An incline of points whose depths have this noise, and whose height over its plane is a saw of steps.
RegionShapePtr Incline(double slope_rad, double step_m, double distance_m, double disparity_sigma_px) {
  // Seen from a camera half a metre above the foot.
  const double eye_m = 0.5;
  const double grazing = slope_rad + std::atan2(eye_m, distance_m);
  const double noise_m = TestCamera().DepthSigma(distance_m, disparity_sigma_px) * std::sin(grazing);
  const double along = 1.5 * std::cos(slope_rad), up = 1.5 * std::sin(slope_rad);
  LabelScene scene;
  scene.Add({{{2, -1, 0}, {2 + along, -1, up}, {2 + along, 1, up}, {2, 1, 0}}, {}, TerrainLabel::kRamp});
  auto polygon = std::make_shared<Polygon>(*scene.Update().changed.front());
  // Means over leaves scatter by half as much as points.
  double sum2 = 0.0;
  constexpr int kSamples = 1000;
  for (int i = 0; i < kSamples; ++i) {
    const double phase = (i + 0.5) / kSamples - 0.5;
    sum2 += std::pow(step_m * std::cos(slope_rad) * phase, 2);
  }
  polygon->noise_m = noise_m;
  polygon->rms_m = std::sqrt(sum2 / kSamples + 0.25 * noise_m * noise_m);
  return MakeRegionShape(polygon, Eigen::Matrix3d::Identity(), {0.52, 1.1, 0.5});
}

constexpr double kSlope = 25.0 * std::numbers::pi / 180.0;

TEST(SlopeEvidenceTest, StepsThatShowGrowWithTheSquareOfTheDistance) {
  const double near = LowestStepThatShows(*Incline(kSlope, 0.0, 2.0, 0.2));
  const double far = LowestStepThatShows(*Incline(kSlope, 0.0, 4.0, 0.2));
  const double grazing = std::sin(kSlope + std::atan2(0.5, 4.0)) / std::sin(kSlope + std::atan2(0.5, 2.0));
  EXPECT_NEAR(far / near, 4.0 * grazing, 1e-9);
}

TEST(SlopeEvidenceTest, CallsARampAPlaneWhereNoStepCouldHideInTheNoise) {
  EXPECT_EQ(JudgeSlope(*Incline(kSlope, 0.0, 1.2, 0.2), {}), SlopeEvidence::kPlane);
  EXPECT_EQ(JudgeSlope(*Incline(kSlope, 0.0, 4.0, 0.2), {}), SlopeEvidence::kNotResolved);
}

TEST(SlopeEvidenceTest, LetsABetterSensorDecideFromFartherAway) {
  EXPECT_EQ(JudgeSlope(*Incline(kSlope, 0.0, 2.5, 0.2), {}), SlopeEvidence::kNotResolved);
  EXPECT_EQ(JudgeSlope(*Incline(kSlope, 0.0, 2.5, 0.05), {}), SlopeEvidence::kPlane);
}

TEST(SlopeEvidenceTest, NeverCallsStepsAPlaneAtAnyDistance) {
  for (const double step_m : {0.05, 0.06, 0.10, 0.17, 0.25})
    for (double distance_m = 0.3; distance_m < 8.0; distance_m *= 1.1)
      for (const double slope_deg : {10.0, 20.0, 30.0, 40.0})
        EXPECT_NE(JudgeSlope(*Incline(slope_deg * std::numbers::pi / 180.0, step_m, distance_m, 0.2), {}),
                  SlopeEvidence::kPlane)
            << "steps of " << step_m << " m at " << distance_m << " m, " << slope_deg << " deg";
}

TEST(SlopeEvidenceTest, TakesLevelAndUprightPiecesForNoStairs) {
  EXPECT_FALSE(CouldBeStairs(*Incline(0.02, 0.0, 2.0, 0.2), {}));
  EXPECT_TRUE(CouldBeStairs(*Incline(kSlope, 0.0, 2.0, 0.2), {}));
}

}  // namespace
}  // namespace terrace
