// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/far_surface.h"

#include <memory>

#include <gtest/gtest.h>

#include "polygonization/polygon_revision.h"

namespace terrace {
namespace {

constexpr double kCell_m = 0.32;

Eigen::Vector3d CentreOfCell(const CellKey& key) {
  return kCell_m * (Eigen::Vector3d(key.x, key.y, key.z).array() + 0.5);
}

/// A square patch of 0.3 m in a sloping plane through the origin.
Patch SlopingPatch(const CellKey& key) {
  Patch patch;
  patch.plane_world.normal = Eigen::Vector3d(0.1, -0.05, 1.0).normalized();
  const Eigen::Vector3d centre = CentreOfCell(key);
  for (const double x : {-0.15, -0.05, 0.05, 0.15}) {
    for (const double y : {-0.15, -0.05, 0.05, 0.15}) {
      const double z = -0.1 * (centre.x() + x) + 0.05 * (centre.y() + y) - centre.z();
      const Eigen::Vector3d p(x, y, z);
      patch.moments.Add(1e5, p);
      if (patch.moments.weight < 2e5) patch.low = patch.high = p.cast<float>();
      patch.low = patch.low.cwiseMin(p.cast<float>());
      patch.high = patch.high.cwiseMax(p.cast<float>());
    }
  }
  patch.area_m2 = 0.09;
  patch.noise_m = patch.most_noise_m = 0.004;
  return patch;
}

/// A surface of 2 x 3 cells whose polygon is an L with a hole.
class FarSurfaceTest : public ::testing::Test {
 protected:
  FarSurfaceTest() {
    for (int x = 0; x < 2; ++x) {
      for (int y = 0; y < 3; ++y) {
        const CellKey key{x, y, -1};
        const MemberRef ref = store_.Add(key, CentreOfCell(key), SlopingPatch(key));
        if (x + y == 0)
          store_.Found(ref);
        else
          store_.Join(ref, kId);
      }
    }
    store_.RefitTouched();
    Surface& surface = store_.surfaces().at(kId);
    TracedPiece piece;
    piece.outline = {{0.0, 0.0}, {0.4, 0.0}, {0.4, 0.3}, {0.2, 0.3}, {0.2, 0.6}, {0.0, 0.6}};
    piece.holes = {{{0.05, 0.05}, {0.05, 0.15}, {0.15, 0.15}, {0.15, 0.05}}};
    piece.area_m2 = 0.17;
    piece.centroid = {0.15, 0.25};
    surface.polygons = {7};
    surface.pieces = {piece};
    surface.trace_now = false;
    polygons_.Put(std::make_shared<const Polygon>(MakePolygon(7, surface, piece, Timestamp{1})));
    surface.evidence.Fill(0, 0, 10, 20);
  }

  static constexpr SurfaceId kId = 1;
  SurfaceStore store_;
  PolygonMap polygons_;
};

TEST_F(FarSurfaceTest, ComesBackWithItsPlaneItsCellsAndItsPolygon) {
  const Surface before = store_.surfaces().at(kId);
  const FarSurface far = Remember(kId, store_);
  store_.Remove(kId);
  EXPECT_TRUE(store_.surfaces().empty());
  EXPECT_EQ(store_.Find({0, 0, -1}), nullptr);

  BringBack(kId, far, polygons_, kCell_m, &store_);
  store_.RefitTouched();
  const Surface& after = store_.surfaces().at(kId);
  EXPECT_EQ(after.cells, before.cells);
  EXPECT_EQ(after.polygons, before.polygons);
  EXPECT_LT((after.plane_world.normal - before.plane_world.normal).norm(), 1e-6);
  EXPECT_NEAR(after.plane_world.offset_m, before.plane_world.offset_m, 1e-6);
  EXPECT_NEAR(after.moments.weight, before.moments.weight, 1e-6 * before.moments.weight);
  EXPECT_NEAR(after.noise_m, before.noise_m, 1e-9);
  EXPECT_NEAR(after.area_m2, before.area_m2, 1e-3 * before.area_m2);
  // The direction is known as well as before, about.
  EXPECT_NEAR(after.angle_sigma_rad, before.angle_sigma_rad, 0.2 * before.angle_sigma_rad);
  ASSERT_EQ(after.pieces.size(), 1U);
  ASSERT_EQ(after.pieces[0].outline.size(), before.pieces[0].outline.size());
  for (std::size_t i = 0; i < after.pieces[0].outline.size(); ++i)
    EXPECT_LT((after.pieces[0].outline[i] - before.pieces[0].outline[i]).norm(), 1e-6);
  EXPECT_NEAR(after.pieces[0].area_m2, before.pieces[0].area_m2, 1e-9);
  const CellMembers& cell = *store_.Find({1, 2, -1});
  EXPECT_TRUE(cell.folded);
  const Patch patch = SlopingPatch({1, 2, -1});
  EXPECT_LT((cell.members[0].low_world - cell.centre_world - patch.low.cast<double>()).norm(), 3e-4);
  EXPECT_LT((cell.members[0].high_world - cell.centre_world - patch.high.cast<double>()).norm(), 3e-4);
}

TEST_F(FarSurfaceTest, ComesBackWithTheEvidenceThatItsOutlineStandsFor) {
  const FarSurface far = Remember(kId, store_);
  EXPECT_EQ(far.strength, 20);
  store_.Remove(kId);
  BringBack(kId, far, polygons_, kCell_m, &store_);
  const EvidenceGrid& evidence = store_.surfaces().at(kId).evidence;
  EXPECT_EQ(evidence.At({0.02, 0.02}), 20);
  EXPECT_EQ(evidence.At({0.395, 0.295}), 20);
  EXPECT_EQ(evidence.At({0.195, 0.595}), 20);
  EXPECT_EQ(evidence.At({0.3, 0.4}), 0) << "the corner that the L leaves out";
  EXPECT_EQ(evidence.At({0.1, 0.1}), EvidenceGrid::kThrough) << "the hole";
  EXPECT_EQ(evidence.At({-0.005, 0.1}), 0);
}

}  // namespace
}  // namespace terrace
