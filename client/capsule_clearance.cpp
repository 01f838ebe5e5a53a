// SPDX-License-Identifier: BSD-3-Clause
#include "client/capsule_clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "client/occupied_space.h"

namespace terrace {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// How the axis of a capsule comes near a face.
struct Nearness {
  double squared_distance = kInfinity;             ///< of the axis
  Eigen::Vector3d away = Eigen::Vector3d::Zero();  ///< from the face's nearest point to the axis's; not unit
  double through_m = 0.0;  ///< how far the axis must be moved along the normal to leave the face; 0: outside
  bool from_behind = false;  ///< the nearest point is seen from the side that nobody has seen

  /// True when it is nearer than what there was, and not beyond the bound.
  bool Take(const Eigen::Vector3d& from_face, double bound_squared) {
    const double squared = from_face.squaredNorm();
    if (!(squared < std::min(squared_distance, bound_squared))) return false;
    squared_distance = squared;
    away = from_face;
    return true;
  }
};

/// From the nearest point of the segment c-d to that of the segment a-b (C. Ericson, "Real-Time Collision
/// Detection", 2005, section 5.1.9).
Eigen::Vector3d BetweenSegments(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                const Eigen::Vector3d& d) {
  constexpr double kPoint = 1e-18;  // squared length of what is no segment
  const Eigen::Vector3d u = b - a, v = d - c, r = a - c;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), vr = v.dot(r);
  double s = 0.0, t = 0.0;
  if (uu <= kPoint) {
    t = vv <= kPoint ? 0.0 : std::clamp(vr / vv, 0.0, 1.0);
  } else if (vv <= kPoint) {
    s = std::clamp(-u.dot(r) / uu, 0.0, 1.0);
  } else {
    const double ur = u.dot(r), uv = u.dot(v);
    const double denominator = uu * vv - uv * uv;
    if (denominator > kPoint) s = std::clamp((uv * vr - ur * vv) / denominator, 0.0, 1.0);
    t = (uv * s + vr) / vv;
    if (t < 0.0 || t > 1.0) {
      t = std::clamp(t, 0.0, 1.0);
      s = std::clamp((uv * t - ur) / uu, 0.0, 1.0);
    }
  }
  return r + s * u - t * v;
}

/// The edges of the face; true when one of them is nearer than what there was.
bool NearEdges(const RegionShape& shape, const Capsule& capsule, double bound_squared, Nearness* nearness) {
  const FlatPolygon& polygon = shape.polygon();
  Eigen::AlignedBox2d axis(shape.ToPlane(capsule.a));
  axis.extend(shape.ToPlane(capsule.b));
  bool found = false;
  polygon.tree().FindNearest(
      [&](const Eigen::AlignedBox2d& box) {
        const double squared = box.squaredExteriorDistance(axis);
        return squared < std::min(nearness->squared_distance, bound_squared) ? squared : kInfinity;
      },
      [&](std::size_t i) {
        const Eigen::Vector3d away = BetweenSegments(capsule.a, capsule.b, shape.ToWorld(polygon.start(i)),
                                                     shape.ToWorld(polygon.end(i)));
        found = nearness->Take(away, bound_squared) || found;
        return away.squaredNorm();
      });
  return found;
}

/// @param bound_squared  what is further away does not count
Nearness Approach(const RegionShape& shape, const Capsule& capsule, double bound_squared) {
  const Eigen::Vector3d& normal = shape.normal_world();
  const double over_a = normal.dot(capsule.a - shape.centroid_world());
  const double over_b = normal.dot(capsule.b - shape.centroid_world());
  Nearness nearness;
  if (over_a * over_b < 0.0) {
    const Eigen::Vector3d crossing = capsule.a + over_a / (over_a - over_b) * (capsule.b - capsule.a);
    if (shape.polygon().Contains(shape.ToPlane(crossing))) {
      // Out again on the side that is nearer.
      const double up_m = -std::min(over_a, over_b), down_m = std::max(over_a, over_b);
      nearness.squared_distance = 0.0;
      nearness.through_m = std::min(up_m, down_m);
      nearness.away = up_m <= down_m ? normal : Eigen::Vector3d(-normal);
      return nearness;
    }
  }
  for (const auto& [p, over] : {std::pair(capsule.a, over_a), std::pair(capsule.b, over_b)}) {
    if (over * over < bound_squared && shape.polygon().Contains(shape.ToPlane(p)))
      nearness.Take(over * normal, bound_squared);
  }
  const bool beside_the_face = NearEdges(shape, capsule, bound_squared, &nearness);
  nearness.from_behind = !beside_the_face && nearness.away.dot(normal) < 0.0;
  return nearness;
}

/// Ground that was seen lies under the whole axis.
bool LiesOverSeenGround(const TerrainQuery& query, const Capsule& capsule) {
  constexpr double kStep_m = 0.05;
  const Eigen::Vector3d along = capsule.b - capsule.a;
  const int num_steps = static_cast<int>(std::ceil(along.head<2>().norm() / kStep_m));
  for (int i = 0; i <= num_steps; ++i) {
    const Eigen::Vector3d p = capsule.a + along * (num_steps == 0 ? 0.0 : 1.0 * i / num_steps);
    const double lowest = num_steps == 0 ? std::min(capsule.a.z(), capsule.b.z()) : p.z();
    const auto ground = query.SupportAt(p.head<2>(), -kInfinity, lowest, kAllLabels);
    if (!ground || ground->source == RegionSource::kPredicted) return false;
  }
  return true;
}

/// The whole capsule lies in the box that the octree was asked about.
bool HasBeenAsked(const OccupiedSpace& space, const Capsule& capsule) {
  const Eigen::Vector3d around = Eigen::Vector3d::Constant(capsule.radius_m);
  Eigen::AlignedBox3d box(capsule.a);
  box.extend(capsule.b);
  return space.box_world().contains(Eigen::AlignedBox3d(box.min() - around, box.max() + around));
}

}  // namespace

Clearance ClearanceOf(const TerrainQuery& query, const Capsule& capsule, LabelSet labels,
                      const OccupiedSpace* space) {
  Eigen::AlignedBox3d axis(capsule.a);
  axis.extend(capsule.b);
  Clearance clearance;
  bool from_behind = false;
  // The deepest of those that it goes through, else the nearest.
  double best = kInfinity;
  const auto look_at = [&](const TerrainQuery::Entry& entry) {
    const double bound = std::max(best, 0.0);
    const Nearness nearness = Approach(*entry.shape, capsule, bound * bound);
    if (nearness.squared_distance == kInfinity) return;
    const double axis_m =
        nearness.through_m > 0.0 ? -nearness.through_m : std::sqrt(nearness.squared_distance);
    if (axis_m >= best) return;
    best = axis_m;
    clearance.distance_m = axis_m - capsule.radius_m;
    clearance.region_id = entry.region->id;
    clearance.gradient_world =
        nearness.away.isZero(0.0) ? entry.shape->normal_world() : Eigen::Vector3d(nearness.away.normalized());
    from_behind = nearness.from_behind;
  };
  query.tree().FindNearest(
      [&](const Eigen::AlignedBox3d& box) {
        const double squared = box.squaredExteriorDistance(axis);
        const double bound = std::max(best, 0.0);
        return squared <= bound * bound ? squared : kInfinity;
      },
      [&](std::size_t i) {
        const TerrainQuery::Entry& entry = query.entries()[query.order()[i]];
        if (labels.Has(entry.region->label)) look_at(entry);
        return kInfinity;  // `best` bounds the search
      });
  if (const auto leaf = space ? space->NearestTo(capsule.a, capsule.b, best) : std::nullopt) {
    clearance.distance_m = leaf->distance_m - capsule.radius_m;
    clearance.region_id = 0;
    clearance.gradient_world = leaf->away_world;
  }
  if (clearance.distance_m <= 0.0) {
    clearance.occupancy = Occupancy::kOccupied;
  } else if (space && HasBeenAsked(*space, capsule) && !from_behind && LiesOverSeenGround(query, capsule)) {
    clearance.occupancy = Occupancy::kFree;
  }
  return clearance;
}

}  // namespace terrace
