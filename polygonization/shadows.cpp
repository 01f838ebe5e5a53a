// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/shadows.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

/// A surface is the shadow of a stronger one that covers it, faces the same way and lies no farther away than
/// this, and so many times its noise.
constexpr double kShadowOffset_m = 0.05;
constexpr double kShadowNoise = 4.0;
constexpr double kShadowAngle_rad = 0.45;
constexpr double kShadowStrength = 4.0;
constexpr double kShadowShare = 0.5;

/// Whether `other` lies over or under a member of the weak surface and belongs to a much stronger one.
bool Covers(const Member& other, const Member& member, const Surface& weak, const SurfaceStore& store) {
  if (other.surface == kNoSurface || other.surface == member.surface) return false;
  const Surface& stronger = store.surfaces().at(other.surface);
  if (stronger.moments.weight < kShadowStrength * weak.moments.weight) return false;
  if (stronger.plane_world.normal.dot(weak.plane_world.normal) < std::cos(kShadowAngle_rad)) return false;
  const double reach = kShadowOffset_m + kShadowNoise * weak.noise_m;
  if (std::abs(stronger.plane_world.SignedDistance(member.mean_world)) > reach) return false;
  const Eigen::Vector3d onto = stronger.plane_world.Project(member.mean_world);
  return ((onto - other.low_world).array() > -kShadowOffset_m).all() &&
         ((other.high_world - onto).array() > -kShadowOffset_m).all();
}

}  // namespace

bool IsShadow(SurfaceId id, const SurfaceStore& store) {
  const Surface& surface = store.surfaces().at(id);
  double covered = 0.0, all = 0.0;
  for (const CellKey& key : surface.cells) {
    for (const Member& member : store.Find(key)->members) {
      if (member.surface != id) continue;
      all += member.patch.area_m2;
      const bool is_covered =
          store.AnyAround(key, [&](const Member& other) { return Covers(other, member, surface, store); });
      if (is_covered) covered += member.patch.area_m2;
    }
  }
  return covered > kShadowShare * all;
}

}  // namespace terrace
