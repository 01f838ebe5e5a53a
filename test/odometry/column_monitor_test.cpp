// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/column_monitor.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace terrace {
namespace {

const StereoCamera kCamera{640, 480, 400.0, 400.0, 319.5, 239.5, 0.12};

/// Landmarks of one keyframe before a camera that moves, and what it measures of them.
class Landmarks {
 public:
  Landmarks(double offset_px, unsigned seed) : random_(seed), offset_px_(offset_px) {
    window_.keyframes.emplace_back();
    std::uniform_real_distribution<double> across(-0.6, 0.6), inverse_depth(0.15, 1.5);
    for (int i = 0; i < 120; ++i) {
      Landmark landmark;
      landmark.id = i;
      landmark.ray_host = {across(random_), across(random_), 1.0};
      true_inverse_depth_.push_back(inverse_depth(random_));
      landmark.disparity_host_px = kFb * true_inverse_depth_.back() + offset_px + Noise(kSigmaDisparity_px);
      landmark.disparity_host_sigma_px = kSigmaDisparity_px;
      window_.landmarks.push_back(landmark);
    }
  }

  /// What the monitor makes of the camera having moved so far, forwards and a little to the right.
  void Show(double moved_m, ColumnMonitor* monitor) {
    Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
    T_world_left.translation() = Eigen::Vector3d(0.3 * moved_m, 0.0, moved_m);
    std::vector<Match> matches;
    for (std::size_t i = 0; i < window_.landmarks.size(); ++i) {
      const Eigen::Vector3d p =
          T_world_left.inverse() * (window_.landmarks[i].ray_host / true_inverse_depth_[i]);
      if (p.z() < 0.3) continue;
      Match match;
      match.landmark = static_cast<int>(i);
      match.measurement.uvd = {kCamera.fx * p.x() / p.z() + kCamera.cx + Noise(kSigmaPixel_px),
                               kCamera.fy * p.y() / p.z() + kCamera.cy + Noise(kSigmaPixel_px),
                               kFb / p.z() + offset_px_ + Noise(kSigmaDisparity_px)};
      match.measurement.covariance_uv = kSigmaPixel_px * kSigmaPixel_px * Eigen::Matrix2d::Identity();
      match.measurement.sigma_d = kSigmaDisparity_px;
      match.measurement.has_disparity = true;
      matches.push_back(match);
    }
    monitor->Update(window_, matches, T_world_left, 1.0);
  }

 private:
  static constexpr double kFb = 400.0 * 0.12;
  static constexpr double kSigmaPixel_px = 0.1, kSigmaDisparity_px = 0.15;

  double Noise(double sigma) { return std::normal_distribution<double>(0.0, sigma)(random_); }

  std::mt19937 random_;
  double offset_px_;
  Window window_;
  std::vector<double> true_inverse_depth_;
};

TEST(ColumnMonitorTest, TheFirstMillimetresOfAWalkSayNothing) {
  for (unsigned seed = 21; seed <= 40; ++seed) {
    Landmarks landmarks(0.0, seed);
    ColumnMonitor monitor(kCamera);
    for (int i = 1; i <= 30; ++i) {
      // Nearly at rest at first, then faster and faster.
      landmarks.Show(i <= 6 ? 1e-5 * i : 0.004 * (i - 6) * (i - 6), &monitor);
      ASSERT_FALSE(monitor.is_off()) << "seed " << seed << ", frame " << i << ": " << monitor.Reason();
    }
  }
}

TEST(ColumnMonitorTest, FindsByHowManyColumnsTheRightImageIsOff) {
  for (const double offset_px : {-3.0, -1.5, 1.5, 3.0}) {
    Landmarks landmarks(offset_px, 7);
    ColumnMonitor monitor(kCamera);
    for (int i = 1; i <= 30; ++i) landmarks.Show(0.02 * i, &monitor);
    EXPECT_TRUE(monitor.is_off()) << offset_px;
    EXPECT_NEAR(monitor.offset_px(), offset_px, 3.0 * monitor.sigma_px());
  }
}

TEST(ColumnMonitorTest, SaysNothingOfAPairThatIsAsItShouldBe) {
  Landmarks landmarks(0.0, 3);
  ColumnMonitor monitor(kCamera);
  for (int i = 1; i <= 30; ++i) {
    landmarks.Show(0.02 * i, &monitor);
    EXPECT_FALSE(monitor.is_off()) << i;
  }
  EXPECT_NEAR(monitor.offset_px(), 0.0, 3.0 * monitor.sigma_px());
}

}  // namespace
}  // namespace terrace
