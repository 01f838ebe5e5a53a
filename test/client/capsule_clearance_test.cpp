// SPDX-License-Identifier: BSD-3-Clause
#include "client/capsule_clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "client/occupied_space.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

/// The slow obvious version: many points of the axis against every edge and the inside of every region.
double SlowAxisDistance(const TerrainMap& map, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  constexpr int kPoints = 200;
  double nearest = kFar;
  for (const auto& region : map.regions) {
    const PlaneAxes axes = AxesOf(region->plane_world.normal);
    std::vector<Ring> rings{region->outline_world};
    rings.insert(rings.end(), region->holes_world.begin(), region->holes_world.end());
    for (int i = 0; i <= kPoints; ++i) {
      const Eigen::Vector3d p = a + (b - a) * (1.0 * i / kPoints);
      bool inside = false;
      const double px = axes.x.dot(p), py = axes.y.dot(p);
      for (const Ring& ring : rings) {
        for (std::size_t k = 0; k < ring.size(); ++k) {
          const Eigen::Vector3d c = ring[k], along = ring[(k + 1) % ring.size()] - c;
          const double t = std::clamp(along.dot(p - c) / along.squaredNorm(), 0.0, 1.0);
          nearest = std::min(nearest, (c + t * along - p).norm());
          const double cy = axes.y.dot(c), dy = axes.y.dot(c + along);
          if ((cy > py) == (dy > py)) continue;
          if (px < axes.x.dot(c) + (py - cy) / (dy - cy) * axes.x.dot(along)) inside = !inside;
        }
      }
      if (inside) nearest = std::min(nearest, std::abs(region->plane_world.SignedDistance(p)));
    }
  }
  return nearest;
}

TEST(CapsuleClearanceTest, IsTheDistanceThatALookAtEveryEdgeFinds) {
  ScatteredTerrain terrain(4);
  const TerrainQuery query(terrain.Map(40, 2.0, 12));
  int num_touching = 0;
  for (int i = 0; i < 80; ++i) {
    const Eigen::Vector3d a(terrain.Real(-2, 2), terrain.Real(-2, 2), terrain.Real(-0.5, 2.5));
    const Eigen::Vector3d b =
        a + 0.4 * Eigen::Vector3d(terrain.Real(-1, 1), terrain.Real(-1, 1), terrain.Real(-1, 1));
    const Clearance clearance = query.CapsuleClearance(a, b, 0.04);
    const double slow = SlowAxisDistance(query.map(), a, b);
    // The points of the slow version lie at most 0.7 m / 200 / 2 from the nearest one.
    if (clearance.distance_m > -0.04) {
      EXPECT_NEAR(clearance.distance_m + 0.04, slow, 2e-3) << i;
    } else {
      EXPECT_LT(slow, 2e-3) << "the axis goes through a face";
    }
    EXPECT_EQ(clearance.occupancy == Occupancy::kOccupied, clearance.distance_m <= 0.0);
    num_touching += clearance.distance_m <= 0.0 ? 1 : 0;
  }
  EXPECT_GT(num_touching, 5);
}

TEST(CapsuleClearanceTest, GradientIsHowTheDistanceChangesWhenTheCapsuleMoves) {
  ScatteredTerrain terrain(9);
  const TerrainQuery query(terrain.Map(30, 2.0, 12));
  constexpr double kMove_m = 1e-6;
  int num_smooth = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d a(terrain.Real(-2, 2), terrain.Real(-2, 2), terrain.Real(-0.5, 2.5));
    const Eigen::Vector3d b =
        a + 0.3 * Eigen::Vector3d(terrain.Real(-1, 1), terrain.Real(-1, 1), terrain.Real(-1, 1));
    const Clearance here = query.CapsuleClearance(a, b, 0.05);
    EXPECT_NEAR(here.gradient_world.norm(), 1.0, 1e-9);
    Eigen::Vector3d slope;
    bool same = true;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d move = kMove_m * Eigen::Vector3d::Unit(axis);
      const Clearance up = query.CapsuleClearance(a + move, b + move, 0.05);
      const Clearance down = query.CapsuleClearance(a - move, b - move, 0.05);
      slope[axis] = (up.distance_m - down.distance_m) / (2.0 * kMove_m);
      same = same && up.region_id == here.region_id && down.region_id == here.region_id;
    }
    if (!same) continue;  // there the nearest face changes
    EXPECT_LT((slope - here.gradient_world).norm(), 1e-2) << i;
    ++num_smooth;
  }
  EXPECT_GT(num_smooth, 150);
}

TEST(CapsuleClearanceTest, SaysFreeOnlyWhereTheOctreeWasAskedInFrontOfFacesAndOverSeenGround) {
  auto floor = MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(0, 0, 2, 2));
  auto inferred = MadeRegion(2, TerrainLabel::kStairTread, LevelAt(0.2), Rectangle(2, 0, 3, 2));
  inferred->source = RegionSource::kPredicted;
  const TerrainQuery query(MadeMap({floor, inferred}));
  const OccupiedSpace empty(Eigen::AlignedBox3d(Eigen::Vector3d(-9, -9, -9), Eigen::Vector3d(9, 9, 0.45)),
                            {});
  const auto leg = [&](double x, double low, double high, const OccupiedSpace* space) {
    return query.CapsuleClearance({x, 1, low}, {x, 1, high}, 0.03, kAllLabels, space);
  };
  EXPECT_EQ(leg(1.0, 0.05, 0.4, &empty).occupancy, Occupancy::kFree);
  EXPECT_EQ(leg(1.0, 0.05, 0.4, nullptr).occupancy, Occupancy::kUnknown) << "nobody has asked the octree";
  EXPECT_EQ(leg(1.0, 0.05, 0.43, &empty).occupancy, Occupancy::kUnknown) << "its end is out of the box";
  EXPECT_NEAR(leg(1.0, 0.05, 0.4, &empty).distance_m, 0.02, 1e-12);
  EXPECT_LT((leg(1.0, 0.05, 0.4, &empty).gradient_world - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(leg(1.0, 0.02, 0.4, nullptr).occupancy, Occupancy::kOccupied);
  EXPECT_EQ(leg(1.0, -0.4, -0.1, &empty).occupancy, Occupancy::kUnknown) << "behind the floor";
  EXPECT_EQ(leg(2.5, 0.3, 0.4, &empty).occupancy, Occupancy::kUnknown) << "over what was inferred";
  EXPECT_EQ(leg(5.0, 0.3, 0.4, &empty).occupancy, Occupancy::kUnknown) << "over nothing";
  EXPECT_EQ(query.CapsuleClearance({1, 1, 0.3}, {-1, 1, 0.3}, 0.03, kAllLabels, &empty).occupancy,
            Occupancy::kUnknown)
      << "its end lies over nothing";
}

TEST(CapsuleClearanceTest, TouchesLeavesOfTheOctreeThatLieOnNoFace) {
  const TerrainQuery query(
      MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(0, 0, 2, 2))}));
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-9, -9, -9), Eigen::Vector3d(9, 9, 9));
  const OccupiedSpace space(box, {{Eigen::Vector3d(1.2, 0.9, 0.3), Eigen::Vector3d(1.3, 1.1, 0.5)}});
  const Clearance near = query.CapsuleClearance({1, 1, 0.35}, {1, 1, 0.45}, 0.05, kAllLabels, &space);
  EXPECT_NEAR(near.distance_m, 0.15, 1e-12);
  EXPECT_EQ(near.region_id, 0);
  EXPECT_LT((near.gradient_world + Eigen::Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_EQ(near.occupancy, Occupancy::kFree);
  EXPECT_EQ(query.CapsuleClearance({1, 1, 0.35}, {1.16, 1, 0.45}, 0.05, kAllLabels, &space).occupancy,
            Occupancy::kOccupied);
  const Clearance through = query.CapsuleClearance({1, 1, 0.4}, {1.22, 1, 0.4}, 0.05, kAllLabels, &space);
  EXPECT_NEAR(through.distance_m, -0.02 - 0.05, 1e-12) << "back by as much as it is in";
  EXPECT_EQ(query.CapsuleClearance({1, 1, 0.1}, {1, 1, 0.2}, 0.05, kAllLabels, &space).region_id, 1)
      << "the floor is nearer";
}

TEST(CapsuleClearanceTest, SaysHowFarALegMustBeMovedOutOfAFace) {
  const TerrainQuery query(
      MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(0, 0, 2, 2))}));
  const Clearance clearance = query.CapsuleClearance({1, 1, -0.02}, {1, 1, 0.5}, 0.03);
  EXPECT_NEAR(clearance.distance_m, -0.05, 1e-12);
  EXPECT_LT((clearance.gradient_world - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(clearance.region_id, 1);
  const Clearance nothing = TerrainQuery(MadeMap({})).CapsuleClearance({1, 1, 0}, {1, 1, 1}, 0.03);
  EXPECT_EQ(nothing.distance_m, kFar);
  EXPECT_EQ(nothing.occupancy, Occupancy::kUnknown);
}

TEST(CapsuleClearanceTest, LooksOnlyAtTheLabelsThatAreAskedFor) {
  const TerrainQuery query(
      MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(0, 0, 2, 2)),
               MadeRegion(2, TerrainLabel::kObstacle, LevelAt(0.4), Rectangle(0, 0, 1, 1))}));
  EXPECT_EQ(query.CapsuleClearance({0.5, 0.5, 0.1}, {0.5, 0.5, 0.3}, 0.03).region_id, 1);
  EXPECT_EQ(
      query.CapsuleClearance({0.5, 0.5, 0.1}, {0.5, 0.5, 0.3}, 0.03, {TerrainLabel::kObstacle}).region_id, 2);
}

}  // namespace
}  // namespace terrace
