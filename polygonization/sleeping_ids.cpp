// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/sleeping_ids.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace terrace {
namespace {

/// How far a small piece moves and turns between two visits; a step is higher, and a riser turns away by
/// more.
constexpr double kSamePlane_m = 0.05;
constexpr double kSameWay_rad = 0.35;
/// Of the smaller one, that lies in both.
constexpr double kFairShare = 0.3;
/// Of the most that any has in common: who has so much is as good, and the oldest of them wakes. Where pieces
/// break and join again, several have lain in one place.
constexpr double kAsGood = 0.5;
/// Points along each side of a box, by which areas are compared.
constexpr int kSamplesAlong = 12;

Eigen::AlignedBox3d BoxAround(const Polygon& polygon) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : polygon.outline_world) box.extend(p);
  return box;
}

Ring2 Along(const PlaneAxes& axes, const Eigen::Vector3d& origin_world, const Ring& ring_world) {
  Ring2 ring;
  ring.reserve(ring_world.size());
  for (const Eigen::Vector3d& p : ring_world)
    ring.emplace_back(axes.x.dot(p - origin_world), axes.y.dot(p - origin_world));
  return ring;
}

Eigen::AlignedBox2d BoxAround(const Ring2& ring) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : ring) box.extend(p);
  return box;
}

}  // namespace

void SleepingIds::Sleep(const Polygon& polygon, int num_observations) {
  Sleeper sleeper;
  sleeper.past = {polygon.id, num_observations, polygon.first_seen};
  sleeper.plane_world = polygon.plane_world;
  sleeper.centroid_world = polygon.centroid_world;
  sleeper.axes = AxesOf(polygon.plane_world.normal);
  sleeper.outline = Along(sleeper.axes, sleeper.centroid_world, polygon.outline_world);
  sleeper.box_world = BoxAround(polygon);
  bytes_ += BytesOf(sleeper);
  sleepers_.emplace(next_turn_++, std::move(sleeper));
  if (sleepers_.size() > kMost) Erase(sleepers_.begin());
}

std::optional<SleepingIds::Past> SleepingIds::Wake(const Polygon& polygon) {
  const Eigen::Vector3d near = Eigen::Vector3d::Constant(kSamePlane_m);
  Eigen::AlignedBox3d around = BoxAround(polygon);
  around = {around.min() - near, around.max() + near};
  const double same_way = std::cos(kSameWay_rad);
  std::vector<std::pair<double, Sleepers::iterator>> candidates;  // by area in common
  double most_m2 = 0.0;
  for (auto at = sleepers_.begin(); at != sleepers_.end(); ++at) {
    const Sleeper& sleeper = at->second;
    if (!around.intersects(sleeper.box_world)) continue;
    if (sleeper.plane_world.normal.dot(polygon.plane_world.normal) < same_way) continue;
    // Either middle may lie where the other plane has been drawn out too far.
    if (std::min(std::abs(sleeper.plane_world.SignedDistance(polygon.centroid_world)),
                 std::abs(polygon.plane_world.SignedDistance(sleeper.centroid_world))) > kSamePlane_m)
      continue;
    const Ring2 outline = Along(sleeper.axes, sleeper.centroid_world, polygon.outline_world);
    const double common_m2 = AreaInCommon(sleeper, outline);
    const double smaller_m2 = std::min(SignedArea(sleeper.outline), std::abs(SignedArea(outline)));
    if (common_m2 <= 0.0 || common_m2 < kFairShare * smaller_m2) continue;
    candidates.emplace_back(common_m2, at);
    most_m2 = std::max(most_m2, common_m2);
  }
  auto oldest = sleepers_.end();
  for (const auto& [common_m2, at] : candidates)
    if (common_m2 >= kAsGood * most_m2 &&
        (oldest == sleepers_.end() || at->second.past.id < oldest->second.past.id))
      oldest = at;
  if (oldest == sleepers_.end()) return std::nullopt;
  const Past past = oldest->second.past;
  Erase(oldest);
  return past;
}

/// Holes count as filled.
double SleepingIds::AreaInCommon(const Sleeper& sleeper, const Ring2& outline) {
  const Eigen::AlignedBox2d box = BoxAround(sleeper.outline).intersection(BoxAround(outline));
  if (box.isEmpty()) return 0.0;
  const Eigen::Vector2d step = box.sizes() / kSamplesAlong;
  int num = 0;
  for (int y = 0; y < kSamplesAlong; ++y) {
    for (int x = 0; x < kSamplesAlong; ++x) {
      const Eigen::Vector2d p = box.min() + step.cwiseProduct(Eigen::Vector2d(x + 0.5, y + 0.5));
      num += Contains(sleeper.outline, p) && Contains(outline, p);
    }
  }
  return num * step.prod();
}

std::int64_t SleepingIds::BytesOf(const Sleeper& sleeper) {
  constexpr std::size_t kNodeBytes = 4 * sizeof(void*) + sizeof(std::int64_t);
  return static_cast<std::int64_t>(kNodeBytes + sizeof(Sleeper) +
                                   sleeper.outline.capacity() * sizeof(Eigen::Vector2d));
}

void SleepingIds::Erase(Sleepers::iterator at) {
  bytes_ -= BytesOf(at->second);
  sleepers_.erase(at);
}

}  // namespace terrace
