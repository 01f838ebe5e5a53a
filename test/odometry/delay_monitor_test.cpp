// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/delay_monitor.h"

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace terrace {
namespace {

const StereoCamera kDelayCamera{640, 480, 400.0, 400.0, 319.5, 239.5, 0.12};
constexpr double kFrame_s = 1.0 / 15.0;

/// Landmarks before a camera that nods and sways as that of a walking robot, and where a pair sees them whose
/// right image is of another moment, and whose rows are off.
class WalkPastLandmarks {
 public:
  WalkPastLandmarks(double late_s, unsigned seed) : random_(seed), late_s_(late_s) {
    window_.keyframes.emplace_back();
    std::uniform_real_distribution<double> across(-2.0, 2.0), ahead(2.0, 9.0);
    for (int i = 0; i < 150; ++i) {
      points_.push_back({across(random_), across(random_), ahead(random_)});
      window_.landmarks.emplace_back();
      window_.landmarks.back().id = i;
    }
  }

  double rows_off_px = 0.0, roll_rad = 0.0;
  /// Of the nodding, which shows the delay.
  double nod_rad = 0.03;

  std::optional<std::string> Show(int frame, DelayMonitor* monitor) {
    const double t_s = frame * kFrame_s;
    std::vector<Match> matches;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d left = SeenAt(points_[i], t_s), right = SeenAt(points_[i], t_s - late_s_);
      if (left.x() < 0 || left.x() > 639 || left.y() < 0 || left.y() > 479) continue;
      Match match;
      match.landmark = static_cast<int>(i);
      match.measurement.uvd = left + Eigen::Vector3d(Noise(), Noise(), Noise());
      match.measurement.has_disparity = match.found_in_right = true;
      match.vertical_px =
          right.y() - left.y() + rows_off_px + roll_rad * (right.x() - kDelayCamera.cx) + Noise();
      matches.push_back(match);
    }
    return monitor->Update(window_, matches, Timestamp{static_cast<std::int64_t>(t_s * 1e9) + 1});
  }

 private:
  double Noise() { return std::normal_distribution<double>(0.0, 0.1)(random_); }

  Eigen::Vector3d SeenAt(const Eigen::Vector3d& point, double t_s) const {
    const double pitch = nod_rad * std::sin(9.0 * t_s), y = 0.01 * std::sin(7.0 * t_s);
    const Eigen::Vector3d from = point - Eigen::Vector3d(0.0, y, 0.5 * t_s);
    const Eigen::Vector3d p = Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) * from;
    return {kDelayCamera.fx * p.x() / p.z() + kDelayCamera.cx,
            kDelayCamera.fy * p.y() / p.z() + kDelayCamera.cy,
            kDelayCamera.fx * kDelayCamera.baseline_m / p.z()};
  }

  std::mt19937 random_;
  double late_s_;
  Window window_;
  std::vector<Eigen::Vector3d> points_;
};

TEST(DelayMonitorTest, MeasuresHowLateEitherCameraIs) {
  for (const double late_s : {-0.067, -0.02, -0.008, 0.008, 0.02, 0.067}) {
    WalkPastLandmarks walk(late_s, 3);
    DelayMonitor monitor(kDelayCamera);
    for (int i = 0; i < 20; ++i) walk.Show(i, &monitor);
    EXPECT_TRUE(monitor.is_off()) << late_s;
    EXPECT_FALSE(monitor.was_right());
    // Motion is taken to be even between frames.
    EXPECT_NEAR(monitor.delay_s(), late_s, 0.001 + 0.15 * std::abs(late_s));
    EXPECT_NE(monitor.Reason().find(late_s > 0 ? "right camera" : "left camera"), std::string::npos);
  }
}

TEST(DelayMonitorTest, SaysNothingOfAPairThatIsOfOneMoment) {
  for (unsigned seed = 101; seed <= 110; ++seed) {
    WalkPastLandmarks walk(0.0, seed);
    DelayMonitor monitor(kDelayCamera);
    for (int i = 0; i < 60; ++i) EXPECT_FALSE(walk.Show(i, &monitor)) << seed << ", " << i;
    EXPECT_TRUE(monitor.was_right());
    EXPECT_NEAR(monitor.delay_s(), 0.0, 5.0 * monitor.sigma_s());
  }
}

TEST(DelayMonitorTest, TakesRowsThatAreOffForNoDelay) {
  WalkPastLandmarks walk(0.0, 5);
  walk.rows_off_px = 1.0;
  walk.roll_rad = 0.01;
  DelayMonitor monitor(kDelayCamera);
  for (int i = 0; i < 40; ++i) EXPECT_FALSE(walk.Show(i, &monitor)) << i;
}

TEST(DelayMonitorTest, KnowsNothingWhileTheCameraStands) {
  WalkPastLandmarks walk(0.067, 5);
  walk.nod_rad = 0.0;
  DelayMonitor monitor(kDelayCamera);
  for (int i = 0; i < 40; ++i) walk.Show(0, &monitor);
  EXPECT_FALSE(monitor.is_off());
  EXPECT_FALSE(monitor.was_right());
  EXPECT_GT(monitor.sigma_s(), 0.05);
}

}  // namespace
}  // namespace terrace
