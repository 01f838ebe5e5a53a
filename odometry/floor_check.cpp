// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/floor_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include <Eigen/Geometry>

namespace terrace {
namespace {

constexpr double kFarthestM = 4.0;
constexpr std::size_t kFewestPoints = 30;

/// Off the plane by what a stereo pair may measure wrongly.
double ToleranceM(double distance_m) { return std::max(0.03, 0.01 * distance_m * distance_m); }

/// How many lie on a plane, and how many beneath it.
struct Support {
  std::size_t on = 0, beneath = 0;
};

Support SupportOf(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& normal,
                  double offset_m) {
  Support support;
  for (const Eigen::Vector3d& p : points) {
    const double height_m = normal.dot(p) - offset_m;
    const double tolerance_m = ToleranceM(p.norm());
    support.on += std::abs(height_m) <= tolerance_m;
    support.beneath += height_m < -2.0 * tolerance_m;
  }
  return support;
}

}  // namespace

double FloorShare(const std::vector<Eigen::Vector3d>& points_left, const Eigen::Vector3d& up_left) {
  constexpr int kTrials = 300;
  constexpr double kMostBeneath = 0.05;  // of all points: wrong matches
  constexpr double kNearestM = 0.1;      // below the camera
  const double level_cosine = std::cos(15.0 * M_PI / 180.0);
  std::vector<Eigen::Vector3d> near;
  for (const Eigen::Vector3d& p : points_left)
    if (p.norm() < kFarthestM) near.push_back(p);
  if (near.size() < kFewestPoints) return 0.0;
  std::mt19937 random(1);  // the same trials each time
  std::size_t most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Vector3d& a = near[random() % near.size()];
    const Eigen::Vector3d& b = near[random() % near.size()];
    const Eigen::Vector3d& c = near[random() % near.size()];
    Eigen::Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 1e-6) continue;
    normal.normalize();
    if (normal.dot(up_left) < 0.0) normal = -normal;
    const double offset_m = normal.dot(a);
    if (normal.dot(up_left) < level_cosine || offset_m > -kNearestM) continue;
    const Support support = SupportOf(near, normal, offset_m);
    if (static_cast<double>(support.beneath) <= kMostBeneath * static_cast<double>(near.size()))
      most = std::max(most, support.on);
  }
  return static_cast<double>(most) / static_cast<double>(near.size());
}

bool FloorConfirmsBody(const std::vector<Eigen::Vector3d>& points_left, const Eigen::Vector3d& body_up_left,
                       const Eigen::Vector3d& image_up_left) {
  constexpr double kLeastShare = 0.3;
  constexpr double kMostOfTheOther = 0.5;
  const double share = FloorShare(points_left, body_up_left);
  return share >= kLeastShare && FloorShare(points_left, image_up_left) < kMostOfTheOther * share;
}

}  // namespace terrace
