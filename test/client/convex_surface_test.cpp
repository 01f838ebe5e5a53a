// SPDX-License-Identifier: BSD-3-Clause
#include "client/convex_surface.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/plane_rings.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

const Eigen::AlignedBox3d kEverywhere(Eigen::Vector3d::Constant(-100.0), Eigen::Vector3d::Constant(100.0));
constexpr double kInset_m = 0.03;

bool Holds(const ConvexSurface& surface, const Eigen::Vector2d& v) {
  return ((surface.A * v - surface.b).array() <= 1e-9).all();
}

/// What can be said of every piece, however it was found.
void ExpectSound(const TerrainQuery& query, const ConvexSurface& surface) {
  ASSERT_GE(surface.vertices.size(), 3u);
  EXPECT_EQ(surface.A.rows(), static_cast<Eigen::Index>(surface.vertices.size()));
  EXPECT_NEAR(surface.area_m2, SignedArea(surface.vertices), 1e-12);
  const RegionShape& shape = *query.Find(surface.region_id)->shape;
  const std::size_t size = surface.vertices.size();
  for (std::size_t i = 0; i < size; ++i) {
    EXPECT_TRUE(Holds(surface, surface.vertices[i])) << "convex, and what A and b say";
    EXPECT_NEAR(surface.A.row(static_cast<Eigen::Index>(i)).norm(), 1.0, 1e-9);
    for (double t = 0.0; t < 1.0; t += 0.05) {
      const Eigen::Vector2d p =
          surface.vertices[i] + t * (surface.vertices[(i + 1) % size] - surface.vertices[i]);
      const Eigen::Vector3d p_world = surface.T_world_plane * Eigen::Vector3d(p.x(), p.y(), 0.0);
      EXPECT_NEAR(query.Find(surface.region_id)->region->plane_world.SignedDistance(p_world), 0.0, 1e-9);
      EXPECT_TRUE(shape.polygon().Contains(shape.ToPlane(p_world)));
      EXPECT_GE(shape.polygon().NearestEdge(shape.ToPlane(p_world)).distance_m, kInset_m - 3e-6);
    }
  }
}

/// Share of a region's inset that the pieces cover, by points of a grid.
double Covered(const TerrainQuery& query, std::int64_t id, const std::vector<ConvexSurface>& surfaces) {
  const RegionShape& shape = *query.Find(id)->shape;
  const auto inset = shape.Inset({kInset_m, kInset_m, kInset_m});
  const Eigen::AlignedBox2d box = inset->box();
  int num_inside = 0, num_covered = 0;
  for (double x = box.min().x(); x < box.max().x(); x += 0.007) {
    for (double y = box.min().y(); y < box.max().y(); y += 0.007) {
      if (!inset->Contains({x, y})) continue;
      ++num_inside;
      for (const ConvexSurface& surface : surfaces) {
        if (surface.region_id != id || !Holds(surface, {x, y})) continue;
        ++num_covered;
        break;
      }
    }
  }
  return static_cast<double>(num_covered) / num_inside;
}

/// A tread with edges that waver as those of real maps do.
std::shared_ptr<TerrainRegion> RaggedTread(std::int64_t id, ScatteredTerrain* terrain) {
  PlanRing ring;
  const auto side = [&](Eigen::Vector2d from, Eigen::Vector2d to) {
    const double length = (to - from).norm();
    for (double s = 0.0; s < length; s += 0.02) {
      const Eigen::Vector2d along = (to - from) / length;
      ring.push_back(from + s * along +
                     terrain->Real(-0.004, 0.004) * Eigen::Vector2d(along.y(), -along.x()));
    }
  };
  side({0, 0}, {0.28, 0});
  side({0.28, 0}, {0.28, 1.4});
  side({0.28, 1.4}, {0, 1.4});
  side({0, 1.4}, {0, 0});
  return MadeRegion(id, TerrainLabel::kStairTread, LevelAt(0.17), ring);
}

TEST(ConvexSurfaceTest, ARectangleIsOnePieceLessItsInset) {
  const TerrainQuery query(
      MadeMap({MadeRegion(4, TerrainLabel::kStairTread, LevelAt(0.2), Rectangle(0, 0, 0.3, 1.2))}));
  const auto surfaces = ConvexSurfaces(query, kEverywhere, kInset_m, 0.01);
  ASSERT_EQ(surfaces.size(), 1u);
  ExpectSound(query, surfaces[0]);
  EXPECT_EQ(surfaces[0].region_id, 4);
  EXPECT_EQ(surfaces[0].label, TerrainLabel::kStairTread);
  EXPECT_NEAR(surfaces[0].area_m2, 0.24 * 1.14, 0.002);
}

TEST(ConvexSurfaceTest, RaggedTreadsAreCoveredByOneOrTwoPieces) {
  ScatteredTerrain terrain(101);
  for (int i = 0; i < 10; ++i) {
    const TerrainQuery query(MadeMap({RaggedTread(1, &terrain)}));
    const auto surfaces = ConvexSurfaces(query, kEverywhere, kInset_m, 0.02);
    EXPECT_LE(surfaces.size(), 2u);
    for (const ConvexSurface& surface : surfaces) ExpectSound(query, surface);
    EXPECT_GE(Covered(query, 1, surfaces), 0.95);
  }
}

TEST(ConvexSurfaceTest, AFloorAroundAColumnIsCoveredByPiecesThatPassIt) {
  const TerrainQuery query(MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0), Rectangle(-2, -2, 2, 2),
                                               {Rectangle(-0.3, -0.3, 0.3, 0.3)})}));
  const auto surfaces = ConvexSurfaces(query, kEverywhere, kInset_m, 0.05);
  for (const ConvexSurface& surface : surfaces) ExpectSound(query, surface);
  EXPECT_LE(surfaces.size(), 6u);
  EXPECT_GE(Covered(query, 1, surfaces), 0.95);
}

TEST(ConvexSurfaceTest, PiecesOfScatteredTerrainAreSoundAndLargeEnough) {
  ScatteredTerrain terrain(102);
  const TerrainQuery query(terrain.Map(40, 5.0));
  const auto surfaces = ConvexSurfaces(query, kEverywhere, kInset_m, 0.03);
  EXPECT_GT(surfaces.size(), 10u);
  for (const ConvexSurface& surface : surfaces) {
    ExpectSound(query, surface);
    EXPECT_GE(surface.area_m2, 0.03);
    EXPECT_TRUE(kWalkableLabels.Has(surface.label));
  }
}

TEST(ConvexSurfaceTest, PiecesEndWhereTheBoxEnds) {
  const TerrainQuery query(
      MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0), Rectangle(-5, -5, 5, 5))}));
  const auto surfaces =
      ConvexSurfaces(query, {Eigen::Vector3d(-1, -0.5, -1), Eigen::Vector3d(1, 0.5, 1)}, kInset_m, 0.01);
  ASSERT_EQ(surfaces.size(), 1u);
  EXPECT_NEAR(surfaces[0].area_m2, 2.0, 1e-3);
}

TEST(ConvexSurfaceTest, TheLargestAroundAPointInAnAngleIsTheArmThatItLiesIn) {
  const PlanRing angle{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};
  const TerrainQuery query(MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0), angle)}));
  const auto along_x = LargestConvexAround(query, {2.5, 0.5, 0}, kInset_m, 8);
  ASSERT_TRUE(along_x);
  ExpectSound(query, *along_x);
  EXPECT_NEAR(along_x->area_m2, 2.94 * 0.94, 0.05);
  const auto along_y = LargestConvexAround(query, {0.5, 1.9, 0}, kInset_m, 8);
  ASSERT_TRUE(along_y);
  EXPECT_GE(along_y->area_m2, 0.95 * 1.94 * 0.94);
}

TEST(ConvexSurfaceTest, TheLargestAroundAPointHasItInsideAndNoMoreVerticesThanAsked) {
  ScatteredTerrain terrain(103);
  const TerrainQuery query(terrain.Map(30, 2.0));
  int num_found = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d point(terrain.Real(-2, 2), terrain.Real(-2, 2), 0.5 * terrain.Int(0, 3));
    const auto surface = LargestConvexAround(query, point, kInset_m, 4);
    if (!surface) continue;
    ++num_found;
    ExpectSound(query, *surface);
    EXPECT_LE(surface->vertices.size(), 4u);
    const Eigen::Vector3d local = surface->T_world_plane.inverse() * point;
    Eigen::Vector2d outside = local.head<2>();
    if (Holds(*surface, outside)) continue;
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < surface->vertices.size(); ++k) {
      const auto& a = surface->vertices[k];
      const auto& b = surface->vertices[(k + 1) % surface->vertices.size()];
      distance = std::min(distance, (NearestOnSegment(a, b, outside) - outside).norm());
    }
    EXPECT_LE(distance, 0.06) << "around the nearest ground within 5 cm";
  }
  EXPECT_GT(num_found, 20);
  EXPECT_FALSE(LargestConvexAround(query, {50, 0, 0}, kInset_m, 4));
}

}  // namespace
}  // namespace terrace
