// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_store.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// A level patch of points on a square about the middle of its cell.
Patch LevelPatch(double height_m) {
  Patch patch;
  patch.plane_world = {Eigen::Vector3d::UnitZ(), height_m};
  for (const double x : {-0.1, 0.0, 0.1})
    for (const double y : {-0.1, 0.0, 0.1}) patch.moments.Add(1e6, {x, y, height_m});
  patch.area_m2 = 0.04;
  return patch;
}

TEST(SurfaceStoreTest, TheMembersOfACellLeaveTheirSurfaceWhenTheyAreTakenOut) {
  SurfaceStore store;
  const CellKey a{0, 0, 0}, b{1, 0, 0};
  store.Found(store.Add(a, {0.0, 0.0, 0.0}, LevelPatch(0.01)));
  const SurfaceId id = store.At({a, 0}).surface;
  store.Join(store.Add(b, {0.32, 0.0, 0.0}, LevelPatch(0.01)), id);
  EXPECT_EQ(store.surfaces().at(id).cells.size(), 2U);
  store.touched().clear();
  EXPECT_EQ(store.TakeOut(a).size(), 1U);
  EXPECT_EQ(store.surfaces().at(id).cells.size(), 1U);
  EXPECT_TRUE(store.touched().contains(id));
  EXPECT_EQ(store.Find(a), nullptr);
}

TEST(SurfaceStoreTest, TheHeapIsCountedAsMembersComeAndGo) {
  SurfaceStore store;
  const std::int64_t before = store.memory_bytes();
  store.Found(store.Add({0, 0, 0}, Eigen::Vector3d::Zero(), LevelPatch(0.0)));
  const std::int64_t one = store.memory_bytes();
  EXPECT_GT(one, before);
  store.Join(store.Add({5, 0, 0}, {1.6, 0.0, 0.0}, LevelPatch(0.0)), 1);
  EXPECT_GT(store.memory_bytes(), one);
  store.TakeOut({5, 0, 0});
  EXPECT_EQ(store.memory_bytes(), one);
}

TEST(SurfaceStoreTest, ThePlaneOfASurfaceIsThatOfAllItsMembers) {
  SurfaceStore store;
  // Two level patches, one 1 cm higher and 32 cm farther: together they lean.
  store.Found(store.Add({0, 0, 0}, Eigen::Vector3d::Zero(), LevelPatch(0.0)));
  store.Join(store.Add({1, 0, 0}, {0.32, 0.0, 0.0}, LevelPatch(0.01)), 1);
  store.RefitTouched();
  PlaneMoments all;
  for (const double x : {-0.1, 0.0, 0.1})
    for (const double y : {-0.1, 0.0, 0.1}) {
      all.Add(1e6, {x, y, 0.0});
      all.Add(1e6, {x + 0.32, y, 0.01});
    }
  const Plane expected = all.Fit(Eigen::Vector3d::UnitZ());
  const Plane& plane = store.surfaces().at(1).plane_world;
  EXPECT_NEAR(plane.normal.x(), expected.normal.x(), 1e-9);
  EXPECT_NEAR(plane.offset_m, expected.offset_m, 1e-9);
}

TEST(SurfaceStoreTest, AnAbsorbedSurfaceLeavesItsMembersAndPolygonsToTheOther) {
  SurfaceStore store;
  store.Found(store.Add({0, 0, 0}, Eigen::Vector3d::Zero(), LevelPatch(0.0)));
  store.Found(store.Add({1, 0, 0}, {0.32, 0.0, 0.0}, LevelPatch(0.0)));
  store.surfaces().at(1).polygons = {7};
  store.surfaces().at(2).polygons = {9};
  store.Absorb(1, 2);
  EXPECT_EQ(store.surfaces().size(), 1U);
  EXPECT_EQ(store.At({{1, 0, 0}, 0}).surface, 1);
  EXPECT_EQ(store.surfaces().at(1).polygons, (std::vector<PolygonId>{7, 9}));
  EXPECT_TRUE(store.surfaces().at(1).trace_now);
}

}  // namespace
}  // namespace terrace
