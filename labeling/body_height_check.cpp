// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/body_height_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/angles.h"

namespace terrace {
namespace {

constexpr std::size_t kNumFrames = 30;

/// Height of the body over the nearest large level ground; none when there is none near it.
std::optional<double> HeightOverGround(const std::vector<RegionShapePtr>& shapes,
                                       const Eigen::Vector3d& body) {
  constexpr double kMinArea = 1.0, kNear = 1.5, kMaxSlope = Radians(5.0);
  double nearest_m = kNear;
  std::optional<double> height_m;
  for (const RegionShapePtr& shape : shapes) {
    if (shape->lean != Lean::kSupport || shape->area_m2 < kMinArea || shape->slope_rad > kMaxSlope) continue;
    Eigen::Vector2d q;
    const double distance_m = shape->PlanDistance(body.head<2>(), &q);
    const double over_m = body.z() - shape->HeightAt(q);
    if (over_m <= 0.0 || distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    height_m = over_m;
  }
  return height_m;
}

}  // namespace

std::optional<std::string> BodyHeightCheck::Look(const std::vector<RegionShapePtr>& shapes,
                                                 const Eigen::Vector3d& body, bool at_feet) {
  if (told_) return std::nullopt;
  num_without_ground_ = at_feet ? 0 : num_without_ground_ + 1;
  const std::optional<double> height_m = HeightOverGround(shapes, body);
  if (!height_m) return std::nullopt;
  heights_m_.push_back(*height_m);
  places_.push_back(body.head<2>());
  if (heights_m_.size() > kNumFrames) {
    heights_m_.erase(heights_m_.begin());
    places_.erase(places_.begin());
  }
  return heights_m_.size() == kNumFrames ? Judge(at_feet) : std::nullopt;
}

std::optional<std::string> BodyHeightCheck::Judge(bool at_feet) {
  constexpr double kSteady = 0.06;   // it bounces by less while it walks on the level
  constexpr double kWalked = 0.5;    // on a slope or on stairs the height would have changed
  constexpr double kDiffers = 0.08;  // legs are bent more or less
  const auto [low, high] = std::minmax_element(heights_m_.begin(), heights_m_.end());
  const bool nothing_at_feet = !at_feet && num_without_ground_ >= static_cast<int>(kNumFrames);
  const bool walked = (places_.back() - places_.front()).norm() >= kWalked;
  if (*high - *low > kSteady || !(walked || nothing_at_feet)) return std::nullopt;
  const double measured_m = 0.5 * (*low + *high);
  if (std::abs(measured_m - body_height_m_) <= kDiffers) return std::nullopt;
  told_ = true;
  std::array<char, 200> text{};
  std::snprintf(
      text.data(), text.size(),
      "robot.body_height_m is %.2f, but the ground that the images show lies %.2f m below the body%s",
      body_height_m_, measured_m, at_feet ? "" : ": until it is set right, labels are unsure");
  return text.data();
}

}  // namespace terrace
