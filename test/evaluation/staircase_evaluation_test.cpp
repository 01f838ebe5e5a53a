// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/staircase_evaluation.h"

#include <gtest/gtest.h>

#include "test/evaluation/exact.h"
#include "test/evaluation/small_world.h"

namespace terrace {
namespace {


/// The camera walks along x towards the foot edge at x = 4, 1 m each second, from x = 0.
std::vector<TimedPose> Approach() {
  std::vector<TimedPose> poses(5);
  for (int i = 0; i < 5; ++i) {
    poses[static_cast<std::size_t>(i)].t.ns = i * 1'000'000'000LL;
    poses[static_cast<std::size_t>(i)].T_world_frame.translation() = Eigen::Vector3d(i, 1, 0.5);
  }
  return poses;
}

StaircaseEvaluation Evaluate(const std::vector<Staircase>& staircases,
                             const std::vector<StaircaseReport>& reports = {}) {
  return EvaluateStaircases(staircases, reports, SmallWorld(), Eigen::Isometry3d::Identity(), Approach());
}

TEST(StaircaseEvaluationTest, GivesPerfectMarksToTheTruth) {
  const StaircaseEvaluation evaluation = Evaluate(MapOf(SmallWorld()).staircases);
  EXPECT_EQ(evaluation.precision, 1.0);
  EXPECT_EQ(evaluation.recall, 1.0);
  ASSERT_EQ(evaluation.matches.size(), 1u);
  EXPECT_EQ(evaluation.matches[0].result_id, 1);
  EXPECT_EQ(evaluation.matches[0].num_risers_error, 0);
  EXPECT_NEAR(evaluation.matches[0].riser_error_m, 0.0, kExact);
  EXPECT_NEAR(evaluation.matches[0].direction_error_deg, 0.0, 1e-5);
  EXPECT_NEAR(evaluation.matches[0].base_error_m, 0.0, kExact);
}

TEST(StaircaseEvaluationTest, TellsByHowMuchAStaircaseIsWrong) {
  std::vector<Staircase> found = MapOf(SmallWorld()).staircases;
  found[0].num_risers = 9;
  found[0].riser_m += 0.01;
  found[0].tread_m -= 0.03;
  found[0].width_m -= 0.2;
  const double a = 5 * EIGEN_PI / 180;
  found[0].direction_up_world = Eigen::Vector3d(std::cos(a), std::sin(a), 0);
  for (Eigen::Vector3d& p : found[0].foot_edge_world) p.x() += 0.1;
  const StaircaseMatch match = Evaluate(found).matches.at(0);
  EXPECT_EQ(match.num_risers_error, -2);
  EXPECT_NEAR(match.riser_error_m, 0.01, kExact);
  EXPECT_NEAR(match.tread_error_m, -0.03, kExact);
  EXPECT_NEAR(match.width_error_m, -0.2, kExact);
  EXPECT_NEAR(match.direction_error_deg, 5.0, 1e-6);
  EXPECT_NEAR(match.base_error_m, 0.1, kExact);
}

TEST(StaircaseEvaluationTest, CountsDuplicatesAndInventionsAgainstPrecision) {
  std::vector<Staircase> found = MapOf(SmallWorld()).staircases;
  Staircase duplicate = found[0];
  duplicate.id = 2;
  duplicate.num_risers = 5;
  Staircase elsewhere = found[0];
  elsewhere.id = 3;
  for (auto* edge : {&elsewhere.foot_edge_world, &elsewhere.head_edge_world}) {
    for (Eigen::Vector3d& p : *edge) p.y() += 5;
  }
  Staircase crosswise = found[0];
  crosswise.id = 4;
  crosswise.direction_up_world = Eigen::Vector3d::UnitY();
  const StaircaseEvaluation evaluation = Evaluate({duplicate, found[0], elsewhere, crosswise});
  EXPECT_EQ(evaluation.num_found, 1);
  EXPECT_EQ(evaluation.matches[0].result_id, 1);  // the one with all its risers
  EXPECT_NEAR(evaluation.precision, 0.25, kExact);
  EXPECT_EQ(evaluation.recall, 1.0);
}

TEST(StaircaseEvaluationTest, MissesAStaircaseThatWasNotReported) {
  const StaircaseEvaluation evaluation = Evaluate({});
  EXPECT_EQ(evaluation.recall, 0.0);
  EXPECT_EQ(evaluation.precision, 1.0);
  EXPECT_FALSE(evaluation.matches[0].result_id);
}

TEST(StaircaseEvaluationTest, TellsFromHowFarItWasFirstReportedAndFirstRight) {
  const Staircase right = MapOf(SmallWorld()).staircases[0];
  Staircase short_one = right;
  short_one.num_risers = 4;
  const StaircaseEvaluation evaluation =
      Evaluate({right}, {{{1'000'000'000}, short_one}, {{3'000'000'000}, right}, {{4'000'000'000}, right}});
  // At 1 s the camera is at x = 1, 3 m before the foot edge; at 3 s one metre.
  EXPECT_NEAR(*evaluation.matches[0].first_reported_m, 3.0, kExact);
  EXPECT_NEAR(*evaluation.matches[0].first_right_m, 1.0, kExact);
}

}  // namespace
}  // namespace terrace
