// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/window_optimizer.h"

#include <random>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include "odometry/covariance.h"
#include "odometry/pose_solver.h"
#include "odometry/rotation.h"
#include "test/odometry/test_cameras.h"

namespace terrace {
namespace {

constexpr double kNoisePx = 0.15;
constexpr double kFb = 400.0 * 0.12;

/// Keyframes along a path, each hosting some landmarks that all later ones see, with noise; poses disturbed.
Window DisturbedWindow(std::vector<Eigen::Isometry3d>* truth) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(40, 600), v(40, 440), d(8, 50);
  std::normal_distribution<double> noise(0.0, kNoisePx);
  Window window;
  for (int k = 0; k < 4; ++k) {
    Keyframe keyframe;
    keyframe.id = k;
    Vector6d step;
    step << 0.01 * k, -0.02 * k, 0.005 * k, 0.02 * k, 0.0, 0.08 * k;
    keyframe.T_world_left = Perturb(Eigen::Isometry3d::Identity(), step);
    truth->push_back(keyframe.T_world_left);
    window.keyframes.push_back(keyframe);
  }
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 25; ++i) {
      Landmark landmark;
      landmark.host = k;
      landmark.pixel_host << u(random), v(random);
      landmark.ray_host << (landmark.pixel_host.x() - kVgaCamera.cx) / kVgaCamera.fx,
          (landmark.pixel_host.y() - kVgaCamera.cy) / kVgaCamera.fy, 1.0;
      const double disparity = d(random);
      landmark.inverse_depth = disparity / kFb;
      for (int t = k + 1; t < 4; ++t) {
        Projection projection;
        const Eigen::Isometry3d T =
            (*truth)[static_cast<std::size_t>(t)].inverse() * (*truth)[static_cast<std::size_t>(k)];
        if (!Project(landmark, T, kVgaCamera, projection)) continue;
        Observation observation;
        observation.keyframe = t;
        observation.measurement.uvd =
            projection.uvd + Eigen::Vector3d(noise(random), noise(random), noise(random));
        observation.measurement.covariance_uv = Eigen::Matrix2d::Identity() * kNoisePx * kNoisePx;
        observation.measurement.sigma_d = kNoisePx;
        observation.measurement.has_disparity = true;
        landmark.observations.push_back(observation);
      }
      landmark.disparity_host_px = disparity + noise(random);
      landmark.disparity_host_sigma_px = kNoisePx;
      landmark.inverse_depth = landmark.disparity_host_px / kFb;
      window.landmarks.push_back(landmark);
    }
  }
  for (int k = 1; k < 4; ++k) {
    Vector6d step;
    step << 0.004, -0.003, 0.002, 0.01, -0.008, 0.012;
    Keyframe& keyframe = window.keyframes[static_cast<std::size_t>(k)];
    keyframe.T_world_left = Perturb(keyframe.T_world_left, step);
  }
  return window;
}

/// The same residuals, written once more, for automatic derivatives. A pose is angle-axis and translation.
struct AutomaticReprojection {
  const Landmark& landmark;
  const StereoMeasurement& measurement;

  template <typename T>
  bool operator()(const T* host, const T* target, const T* inverse_depth, T* residual) const {
    const T ray[3] = {T(landmark.ray_host.x()), T(landmark.ray_host.y()), T(1.0)};
    T world[3], apart[3], q[3];
    ceres::AngleAxisRotatePoint(host, ray, world);
    for (int i = 0; i < 3; ++i) apart[i] = world[i] + inverse_depth[0] * (host[3 + i] - target[3 + i]);
    const T back[3] = {-target[0], -target[1], -target[2]};
    ceres::AngleAxisRotatePoint(back, apart, q);
    residual[0] = (kVgaCamera.fx * q[0] / q[2] + kVgaCamera.cx - measurement.uvd.x()) / kNoisePx;
    residual[1] = (kVgaCamera.fy * q[1] / q[2] + kVgaCamera.cy - measurement.uvd.y()) / kNoisePx;
    residual[2] = (kFb * inverse_depth[0] / q[2] - measurement.uvd.z()) / kNoisePx;
    return true;
  }
};
struct AutomaticDisparity {
  double measured;
  template <typename T>
  bool operator()(const T* inverse_depth, T* residual) const {
    residual[0] = (kFb * inverse_depth[0] - measured) / kNoisePx;
    return true;
  }
};

std::vector<Eigen::Isometry3d> SolvedByCeres(const Window& window) {
  std::vector<std::array<double, 6>> poses;
  for (const Keyframe& keyframe : window.keyframes) {
    std::array<double, 6> pose{};
    Eigen::Map<Eigen::Vector3d>(pose.data()) = LogRotation(keyframe.T_world_left.linear());
    Eigen::Map<Eigen::Vector3d>(pose.data() + 3) = keyframe.T_world_left.translation();
    poses.push_back(pose);
  }
  std::vector<double> depths;
  for (const Landmark& landmark : window.landmarks) depths.push_back(landmark.inverse_depth);
  ceres::Problem problem;
  for (std::size_t i = 0; i < window.landmarks.size(); ++i) {
    const Landmark& landmark = window.landmarks[i];
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AutomaticDisparity, 1, 1>(
                                 new AutomaticDisparity{landmark.disparity_host_px}),
                             nullptr, &depths[i]);
    for (const Observation& observation : landmark.observations) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AutomaticReprojection, 3, 6, 6, 1>(
                                   new AutomaticReprojection{landmark, observation.measurement}),
                               new ceres::CauchyLoss(std::sqrt(6.0)),
                               poses[static_cast<std::size_t>(landmark.host)].data(),
                               poses[static_cast<std::size_t>(observation.keyframe)].data(), &depths[i]);
    }
  }
  problem.SetParameterBlockConstant(poses[0].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.dense_linear_algebra_library_type = ceres::EIGEN;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  std::vector<Eigen::Isometry3d> solved;
  for (const auto& pose : poses) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = ExpRotation(Eigen::Map<const Eigen::Vector3d>(pose.data()));
    T.translation() = Eigen::Map<const Eigen::Vector3d>(pose.data() + 3);
    solved.push_back(T);
  }
  return solved;
}

TEST(WindowOptimizerTest, FindsTheSameOptimumAsCeresWithAutomaticDerivatives) {
  std::vector<Eigen::Isometry3d> truth;
  Window window = DisturbedWindow(&truth);
  const std::vector<Eigen::Isometry3d> reference = SolvedByCeres(window);
  WindowOptimizer optimizer(kVgaCamera, std::nullopt);
  optimizer.Start(window.keyframes.front(), Matrix6d::Zero(), 0.1);
  Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  for (int round = 0; round < 5; ++round) optimizer.Optimize(window, down, 1.0, 10);
  for (std::size_t k = 1; k < 4; ++k) {
    // The truth is near, the reference is the same but for where each of them stops.
    EXPECT_LT(StepBetween(truth[k], window.keyframes[k].T_world_left).tail<3>().norm(), 0.004);
    EXPECT_LT(StepBetween(reference[k], window.keyframes[k].T_world_left).norm(), 1e-4) << "keyframe " << k;
  }
}

TEST(WindowOptimizerTest, WhatLeavesTheWindowStillHoldsTheRestInPlace) {
  std::vector<Eigen::Isometry3d> truth;
  Window window = DisturbedWindow(&truth);
  WindowOptimizer optimizer(kVgaCamera, std::nullopt);
  optimizer.Start(window.keyframes.front(), Matrix6d::Zero(), 0.1);
  Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  for (int round = 0; round < 5; ++round) optimizer.Optimize(window, down, 1.0, 10);
  const Eigen::Isometry3d before = window.keyframes.back().T_world_left;
  const Matrix6d covariance_before = optimizer.newest_covariance();

  optimizer.DropOldest(window, down, 1.0);
  ASSERT_EQ(window.keyframes.size(), 3u);
  for (const Landmark& landmark : window.landmarks) EXPECT_GE(landmark.host, 1);
  optimizer.Optimize(window, down, 1.0, 10);
  EXPECT_LT(StepBetween(before, window.keyframes.back().T_world_left).norm(), 1e-4);
  EXPECT_NEAR(optimizer.newest_covariance().trace() / covariance_before.trace(), 1.0, 0.02);
}

TEST(WindowOptimizerTest, ClaimsTheErrorsItMakes) {
  std::vector<Eigen::Isometry3d> truth;
  Window window = DisturbedWindow(&truth);
  WindowOptimizer optimizer(kVgaCamera, std::nullopt);
  optimizer.Start(window.keyframes.front(), Matrix6d::Zero(), 0.1);
  Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  optimizer.Optimize(window, down, 1.0, 20);
  const Vector6d error = StepBetween(truth.back(), window.keyframes.back().T_world_left);
  EXPECT_LT(Chi2(error, optimizer.newest_covariance()), 20.0);  // six degrees of freedom
}

}  // namespace
}  // namespace terrace
