// SPDX-License-Identifier: BSD-3-Clause
#include "client/convex_cover.h"

#include <algorithm>
#include <utility>

#include "client/convex_inflation.h"
#include "client/convex_ring.h"
#include "client/deepest_point.h"
#include "client/inset.h"
#include "core/plane_rings.h"

namespace terrace {
namespace {

constexpr std::size_t kMaxVertices = 12;
// Enough is covered when this share is left; and another ring that covers less of it is not worth having.
constexpr double kLeft = 0.04;
constexpr double kWorthHaving = 0.02;
// Strips between rings and a ragged border are thinner.
constexpr double kThin_m = 0.008;
constexpr int kMaxTries = 200;

}  // namespace

std::vector<FlatRing> ConvexCover(const FlatPolygon& free, double min_area_m2) {
  std::vector<FlatRing> cover;
  FlatPolygon left = free;
  for (int i = 0; i < kMaxTries && left.area_m2() > kLeft * free.area_m2(); ++i) {
    const DeepPoint deepest = DeepestPoint(left, 0.25 * kThin_m);
    if (deepest.depth_m < kThin_m) break;
    Inflation new_ground;
    new_ground.worth = [&](const FlatRing& ring) { return Within(left, ring).area_m2(); };
    FlatRing ring = Inflate(free, deepest.point, new_ground);
    if (ring.empty()) break;
    const Eigen::Vector2d middle = MomentsOf(ring).middle;
    ring = WithFewerVertices(std::move(ring), kMaxVertices, middle);
    const double gain_m2 = Within(left, ring).area_m2();
    left = Without(left, {ring, RingOf({deepest.point - Eigen::Vector2d::Constant(0.5 * kThin_m),
                                        deepest.point + Eigen::Vector2d::Constant(0.5 * kThin_m)})});
    const double worth_m2 = std::min(min_area_m2, kWorthHaving * free.area_m2());
    if (SignedArea(ring) >= min_area_m2 && gain_m2 >= worth_m2) cover.push_back(std::move(ring));
  }
  return cover;
}

}  // namespace terrace
