// SPDX-License-Identifier: BSD-3-Clause
#include "client/convex_straightening.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "client/convex_ring.h"
#include "core/plane_rings.h"

namespace terrace {
namespace {

/// normal . p <= offset
struct Side {
  Eigen::Vector2d normal;
  double offset;
};

std::vector<Side> SidesOf(const FlatRing& ring) {
  std::vector<Side> sides;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d along = ring[(i + 1) % ring.size()] - ring[i];
    if (along.norm() < 1e-9) continue;
    const Eigen::Vector2d outward = Eigen::Vector2d(along.y(), -along.x()).normalized();
    sides.push_back({outward, outward.dot(ring[i])});
  }
  return sides;
}

/// What all sides but one leave of the box.
FlatRing WithoutSide(const std::vector<Side>& sides, std::size_t left_out, const Eigen::AlignedBox2d& box) {
  FlatRing ring = RingOf(box);
  for (std::size_t i = 0; i < sides.size() && !ring.empty(); ++i) {
    if (i != left_out) ring = Cut(ring, sides[i].normal, sides[i].offset);
  }
  return ring;
}

/// One side laid anew.
class SideSearch {
 public:
  SideSearch(const FlatPolygon& free, FlatRing without_side, const Eigen::Vector2d& keep_inside)
      : without_side_(std::move(without_side)), keep_inside_(keep_inside) {
    for (std::size_t i = 0; i < free.num_edges(); ++i) {
      const auto part = PartInside(without_side_, free.start(i), free.end(i));
      if (part) kept_out_.insert(kept_out_.end(), {part->first, part->second});
    }
  }

  /// The side is not needed at all.
  bool needless() const { return kept_out_.empty(); }

  /// From the side as it was, turned by less and less.
  Side Best(const Side& before) const {
    constexpr double kFirstTurn_rad = 0.2;
    constexpr double kLastTurn_rad = 5e-4;
    double angle = std::atan2(before.normal.y(), before.normal.x());
    double most = Leaves(Against(angle));
    for (double turn = kFirstTurn_rad; turn > kLastTurn_rad; turn *= 0.5) {
      for (const double sign : {-1.0, 1.0}) {
        const double leaves = Leaves(Against(angle + sign * turn));
        if (!(leaves > most)) continue;
        most = leaves;
        angle += sign * turn;
        break;
      }
    }
    return Against(angle);
  }

 private:
  /// As far out as what it keeps out allows.
  Side Against(double angle) const {
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    double offset = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& p : kept_out_) offset = std::min(offset, normal.dot(p));
    return {normal, offset};
  }

  double Leaves(const Side& side) const {
    if (!(side.normal.dot(keep_inside_) < side.offset)) return 0.0;
    const FlatRing ring = Cut(without_side_, side.normal, side.offset);
    return ring.empty() ? 0.0 : SignedArea(ring);
  }

  FlatRing without_side_;
  Eigen::Vector2d keep_inside_;
  std::vector<Eigen::Vector2d> kept_out_;
};

}  // namespace

FlatRing Straightened(const FlatPolygon& free, FlatRing ring, const Eigen::Vector2d& keep_inside) {
  constexpr int kSweeps = 4;
  constexpr double kGain = 1.002;
  const Eigen::AlignedBox2d box = free.box();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double before = SignedArea(ring);
    std::vector<Side> sides = SidesOf(ring);
    for (std::size_t i = 0; i < sides.size();) {
      const SideSearch search(free, WithoutSide(sides, i, box), keep_inside);
      if (search.needless()) {
        sides.erase(sides.begin() + static_cast<std::ptrdiff_t>(i));
        continue;
      }
      sides[i] = search.Best(sides[i]);
      ++i;
    }
    FlatRing straight = WithoutSide(sides, sides.size(), box);
    if (straight.empty() || !(SignedArea(straight) > before)) break;
    ring = std::move(straight);
    if (SignedArea(ring) < kGain * before) break;
  }
  return ring;
}

}  // namespace terrace
