// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/pose_solver.h"

#include <random>

#include <gtest/gtest.h>

#include "odometry/rotation.h"
#include "test/odometry/test_cameras.h"

namespace terrace {
namespace {

std::vector<PoseConstraint> Points(const Eigen::Isometry3d& T_world_left, int num, int num_wrong,
                                   double noise_px) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(20, 620), v(20, 460), d(4, 60);
  std::normal_distribution<double> noise(0.0, noise_px);
  std::vector<PoseConstraint> constraints;
  for (int i = 0; i < num; ++i) {
    const Eigen::Vector3d uvd(u(random), v(random), d(random));
    PoseConstraint c;
    c.point_world = T_world_left * kVgaCamera.Triangulate(uvd.x(), uvd.y(), uvd.z());
    c.inverse_depth = 1.0;
    c.uvd = uvd + Eigen::Vector3d(noise(random), noise(random), noise(random));
    if (i < num_wrong) c.uvd += Eigen::Vector3d(15.0, -8.0, 3.0);  // all wrong ones agree with each other
    c.whitening /= 0.2;
    constraints.push_back(c);
  }
  return constraints;
}

TEST(PoseSolverTest, FindsThePoseAlthoughTwoFifthsOfThePointsMoveTogether) {
  Vector6d motion;
  motion << 0.05, -0.08, 0.03, 0.1, -0.05, 0.2;
  const Eigen::Isometry3d truth = Perturb(Eigen::Isometry3d::Identity(), motion);
  PosePrior prior;
  prior.information.diagonal().setConstant(1.0 / 0.04);
  const PoseSolution solution = SolvePose(Points(truth, 120, 48, 0.2), prior, kVgaCamera, 3);
  const Vector6d error = StepBetween(truth, solution.T_world_left);
  EXPECT_LT(error.head<3>().norm(), 0.002);
  EXPECT_LT(error.tail<3>().norm(), 0.005);
  EXPECT_GE(solution.num_inliers, 68);
  EXPECT_LE(solution.num_inliers, 74);
}

TEST(PoseSolverTest, ClaimsTheErrorsItMakes) {
  PosePrior prior;
  prior.information.diagonal().setConstant(1.0);
  const Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  const PoseSolution solution = SolvePose(Points(truth, 200, 0, 0.2), prior, kVgaCamera, 3);
  const Vector6d error = StepBetween(truth, solution.T_world_left);
  const double normalised = error.dot(solution.information * error);
  EXPECT_LT(normalised, 20.0);  // six degrees of freedom
  EXPECT_NEAR(solution.mean_chi2, 1.0, 0.25);
}

TEST(PoseSolverTest, GivesTheSameBitsTwice) {
  PosePrior prior;
  prior.information.diagonal().setConstant(1.0);
  const auto points = Points(Eigen::Isometry3d::Identity(), 100, 30, 0.3);
  const PoseSolution a = SolvePose(points, prior, kVgaCamera, 11);
  const PoseSolution b = SolvePose(points, prior, kVgaCamera, 11);
  EXPECT_EQ(a.T_world_left.matrix(), b.T_world_left.matrix());
  EXPECT_EQ(a.inlier, b.inlier);
}

}  // namespace
}  // namespace terrace
