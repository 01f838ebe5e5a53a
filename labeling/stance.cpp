// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/stance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {
namespace {

constexpr double kSpacing = 0.25;
/// The oldest ones are forgotten: by then the ground hangs together.
constexpr std::size_t kMaxStances = 128;
/// A centimetre of height counts as much as three of distance.
constexpr double kHeightWeight = 3.0;

int IndexOf(const std::vector<RegionShapePtr>& shapes, PolygonId id) {
  const auto it =
      std::lower_bound(shapes.begin(), shapes.end(), id,
                       [](const RegionShapePtr& s, PolygonId wanted) { return s->id() < wanted; });
  if (it == shapes.end() || (*it)->id() != id || (*it)->lean != Lean::kSupport) return -1;
  return static_cast<int>(it - shapes.begin());
}

int NearestSupport(const std::vector<RegionShapePtr>& shapes, const Eigen::Vector3d& ground,
                   const StanceLimits& limits) {
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    const RegionShape& s = *shapes[i];
    if (s.lean != Lean::kSupport) continue;
    // Most lie far from a stance of long ago: that takes no walk around their rings.
    const Eigen::Vector3d before = s.bounds.min() - ground, behind = ground - s.bounds.max();
    if (std::max(before.head<2>().maxCoeff(), behind.head<2>().maxCoeff()) > limits.max_distance_m) continue;
    Eigen::Vector2d q;
    const double distance = s.PlanDistance(ground.head<2>(), &q);
    const double height = std::abs(s.HeightAt(q) - ground.z());
    if (distance > limits.max_distance_m || height > limits.height_tolerance_m) continue;
    const double cost = distance + kHeightWeight * height;
    if (cost >= least) continue;
    least = cost;
    nearest = i;
  }
  return nearest;
}

/// When the height of the body is not what the settings say (a camera in the hand, on a car), the largest
/// support below it must do.
int LargestSupportBelow(const std::vector<RegionShapePtr>& shapes, const Eigen::Vector3d& ground) {
  constexpr double kMaxDistance = 6.0;
  int largest = -1;
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    const RegionShape& s = *shapes[i];
    if (s.lean != Lean::kSupport || s.centroid.z() > ground.z()) continue;
    if (s.PlanDistance(ground.head<2>()) > kMaxDistance) continue;
    if (largest < 0 || s.area_m2 > shapes[largest]->area_m2) largest = i;
  }
  return largest;
}

}  // namespace

void StanceMemory::Stand(const Eigen::Vector3d& body_world, const Eigen::Matrix3d& R_level_world) {
  const Eigen::Vector3d up_world = R_level_world.transpose().col(2);
  const Eigen::Vector3d ground_world = body_world - limits_.body_height_m * up_world;
  const bool moved =
      past_.size() < 2 || (past_[past_.size() - 2].ground_world - ground_world).norm() > kSpacing;
  if (past_.empty() || moved)
    past_.push_back({ground_world, 0});
  else
    past_.back() = {ground_world, 0};
  if (past_.size() > kMaxStances) past_.erase(past_.begin());
}

std::vector<int> StanceMemory::Seeds(const std::vector<RegionShapePtr>& shapes,
                                     const Eigen::Matrix3d& R_level_world) {
  std::vector<int> seeds;
  for (Stance& stance : past_) {
    int i = stance.ground != 0 ? IndexOf(shapes, stance.ground) : -1;
    if (i < 0) {
      i = NearestSupport(shapes, R_level_world * stance.ground_world, limits_);
      stance.ground = i < 0 ? 0 : shapes[i]->id();
    }
    if (i >= 0) seeds.push_back(i);
  }
  at_feet_ = !seeds.empty();
  disagrees_ = false;
  if (seeds.empty() && !past_.empty()) {
    const int i = LargestSupportBelow(shapes, R_level_world * past_.back().ground_world);
    constexpr double kLarge_m2 = 1.0;
    disagrees_ = i >= 0 && shapes[i]->area_m2 >= kLarge_m2;
    if (i >= 0) seeds.push_back(i);
  }
  std::sort(seeds.begin(), seeds.end());
  seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
  return seeds;
}

}  // namespace terrace
