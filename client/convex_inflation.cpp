// SPDX-License-Identifier: BSD-3-Clause
#include "client/convex_inflation.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include "client/convex_ring.h"
#include "client/convex_straightening.h"
#include "core/plane_rings.h"

namespace terrace {
namespace {

/// What the edges of `free` leave around `middle`, when distances are measured as |stretch (p - middle)|.
FlatRing PushedAway(const FlatPolygon& free, const Eigen::Vector2d& middle, const Eigen::Matrix2d& stretch) {
  const auto nearest = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector2d from = stretch * (a - middle), to = stretch * (b - middle), origin(0.0, 0.0);
    return NearestOnSegment(from, to, origin);
  };
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < free.num_edges(); ++i)
    by_distance.emplace_back(nearest(free.start(i), free.end(i)).squaredNorm(), i);
  std::sort(by_distance.begin(), by_distance.end());
  FlatRing ring = RingOf(free.box());
  for (const auto& [distance, i] : by_distance) {
    const auto part = PartInside(ring, free.start(i), free.end(i));
    if (!part) continue;
    const Eigen::Vector2d touch = nearest(part->first, part->second);
    const Eigen::Vector2d normal = (stretch.transpose() * touch).normalized();
    const Eigen::Vector2d point = middle + stretch.inverse() * touch;
    ring = Cut(ring, normal, normal.dot(point));
    if (ring.empty()) return ring;
  }
  return ring;
}

/// The measure in which the area is round, or (power 1) twice as drawn out as it is.
Eigen::Matrix2d StretchFor(const Eigen::Matrix2d& covariance, double power) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const Eigen::Vector2d sizes = solver.eigenvalues().cwiseMax(1e-12 * solver.eigenvalues().maxCoeff());
  const Eigen::Vector2d weights = (sizes / sizes.maxCoeff()).array().pow(-power).cwiseMin(1e4);
  return weights.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

FlatRing Inflate(const FlatPolygon& free, const Eigen::Vector2d& seed, const Inflation& how) {
  if (free.empty() || !free.Contains(seed)) return {};
  const auto worth = [&](const FlatRing& ring) { return how.worth ? how.worth(ring) : SignedArea(ring); };
  FlatRing best = PushedAway(free, seed, Eigen::Matrix2d::Identity());
  if (best.empty()) return {};
  double best_worth = worth(best);
  constexpr int kRounds = 6;
  constexpr double kGain = 1.003;
  for (int round = 0; round < kRounds; ++round) {
    const double before = best_worth;
    const AreaMoments moments = MomentsOf(best);
    const Eigen::Vector2d middle = how.keep_seed ? seed : moments.middle;
    // Along a ragged edge, a drawn-out measure turns the cut less away from the edge's own direction.
    for (const double power : {0.5, 1.0}) {
      FlatRing ring = PushedAway(free, middle, StretchFor(moments.covariance, power));
      if (ring.empty() || !(worth(ring) > best_worth)) continue;
      best_worth = worth(ring);
      best = std::move(ring);
    }
    if (best_worth < kGain * before) break;
  }
  // Ragged edges leave many short sides, of which each would be laid anew.
  constexpr std::size_t kMaxSides = 20;
  const Eigen::Vector2d middle = how.keep_seed ? seed : MomentsOf(best).middle;
  return Straightened(free, WithFewerVertices(std::move(best), kMaxSides, middle), middle);
}

}  // namespace terrace
