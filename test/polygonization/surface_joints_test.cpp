// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_joints.h"

#include <cmath>

#include <gtest/gtest.h>

namespace terrace {
namespace {

constexpr SurfaceId kLower = 1, kFace = 2, kUpper = 3;
constexpr double kKerb_m = 0.1;
constexpr std::int8_t kWellKnown = 10;

/// Ground with a face along y = 0, towards which it was seen from y < 0, and perhaps higher ground behind it.
/// All of it was seen along x from 0 to 3 m, unless a test says otherwise.
class SurfaceJointsTest : public testing::Test {
 protected:
  SurfaceJointsTest() {
    Begin(kLower, Eigen::Vector3d::UnitZ(), 0.0);
    Begin(kFace, -Eigen::Vector3d::UnitY(), 0.0);
  }

  void Begin(SurfaceId id, const Eigen::Vector3d& normal, double height_m) {
    Surface& surface = store_.Begin(id);
    surface.plane_world = {normal, normal.z() * height_m};
    surface.origin_world = {0.0, 0.0, height_m};
    surface.anchor_normal = normal;
    surface.axes = {Eigen::Vector3d::UnitX(), normal.cross(Eigen::Vector3d::UnitX())};
    neighbours_[id] =
        Eigen::AlignedBox3d(Eigen::Vector3d(0, -0.3, height_m), Eigen::Vector3d(3, 0.3, height_m));
  }

  /// Across is y of ground, and z of the face.
  void See(SurfaceId id, double from_x, double to_x, double from_across, double to_across,
           std::int8_t known = kWellKnown) {
    EvidenceGrid& grid = store_.surfaces().at(id).evidence;
    grid.Open({from_x, from_across}, {to_x, to_across});
    for (int row = grid.CellIndex(from_across); row < grid.CellIndex(to_across); ++row)
      grid.Fill(row, grid.CellIndex(from_x), grid.CellIndex(to_x), known);
  }

  PlaneBitmap Cut(SurfaceId id) {
    Neighbours others = neighbours_;
    others.erase(id);
    PlaneBitmap bitmap = BitmapOf(store_.surfaces().at(id).evidence, 10);
    CutAtJoints(id, others, store_, &bitmap);
    return bitmap;
  }

  SurfaceStore store_;
  Neighbours neighbours_;
};

/// The face of a kerb is seen for the first metre only; farther on pixels agree with either ground for a
/// while beyond its end.
class KerbTest : public SurfaceJointsTest {
 protected:
  KerbTest() {
    Begin(kUpper, Eigen::Vector3d::UnitZ(), kKerb_m);
    See(kFace, 0.0, 1.0, 0.0, kKerb_m);
    See(kLower, 0.0, 3.0, -1.0, 0.08);
    See(kUpper, 0.0, 3.0, -0.08, 1.0);
  }
};

TEST_F(KerbTest, GroundEndsAtItsFace) {
  const PlaneBitmap lower = Cut(kLower), upper = Cut(kUpper);
  EXPECT_TRUE(lower.OnAt({0.5, -0.02}));
  EXPECT_FALSE(lower.OnAt({0.5, 0.02}));
  EXPECT_TRUE(upper.OnAt({0.5, 0.02}));
  EXPECT_FALSE(upper.OnAt({0.5, -0.02}));
}

TEST_F(KerbTest, GroundEndsAtTheLineOfItsFaceWhereThatIsNotSeen) {
  const PlaneBitmap lower = Cut(kLower), upper = Cut(kUpper);
  for (const double x : {1.2, 2.0, 2.4}) {
    EXPECT_TRUE(lower.OnAt({x, -0.02})) << x;
    EXPECT_FALSE(lower.OnAt({x, 0.02})) << x;
    EXPECT_TRUE(upper.OnAt({x, 0.02})) << x;
    EXPECT_FALSE(upper.OnAt({x, -0.02})) << x;
  }
}

TEST_F(SurfaceJointsTest, GroundGoesOnBeyondTheEndOfAFaceWhereNoOtherGroundIs) {
  See(kFace, 0.0, 1.0, 0.0, 0.4);
  See(kLower, 0.0, 1.0, -1.0, 0.05);
  See(kLower, 1.0, 3.0, -1.0, 1.0);
  const PlaneBitmap lower = Cut(kLower);
  EXPECT_FALSE(lower.OnAt({0.5, 0.02}));
  EXPECT_TRUE(lower.OnAt({2.0, 0.02}));
  EXPECT_TRUE(lower.OnAt({2.0, -0.02}));
}

TEST_F(SurfaceJointsTest, GroundEndsAtAWallThatIsKnownFromSomeWayUpOnly) {
  See(kFace, 0.0, 3.0, 0.1, 0.8);
  See(kLower, 0.0, 3.0, -1.0, 0.08);
  const PlaneBitmap lower = Cut(kLower);
  EXPECT_TRUE(lower.OnAt({1.5, -0.02}));
  EXPECT_FALSE(lower.OnAt({1.5, 0.02}));
}

TEST_F(SurfaceJointsTest, GroundGoesOnUnderAFaceThatOneSeesUnder) {
  See(kFace, 0.0, 3.0, 0.1, 0.8);
  See(kFace, 0.0, 3.0, 0.0, 0.1, -kWellKnown);
  See(kLower, 0.0, 3.0, -1.0, 0.08);
  EXPECT_TRUE(Cut(kLower).OnAt({1.5, 0.05}));
}

TEST_F(SurfaceJointsTest, AFaceDoesNotGoOnAlongTheGroundBesideIt) {
  See(kFace, 0.0, 1.0, 0.0, 0.5);
  See(kFace, 1.0, 1.2, 0.0, 0.04);
  See(kLower, 0.0, 3.0, -1.0, 0.0);
  See(kLower, 1.0, 3.0, 0.0, 1.0);
  const PlaneBitmap face = Cut(kFace);
  EXPECT_TRUE(face.OnAt({0.5, 0.015}));
  EXPECT_TRUE(face.OnAt({0.9, 0.015}));
  EXPECT_FALSE(face.OnAt({1.1, 0.015}));
}

TEST_F(SurfaceJointsTest, GroundDoesNotGoOnAlongAWallBeyondItsEnd) {
  See(kFace, 0.0, 3.0, -0.5, 0.5);
  See(kLower, 0.0, 1.0, -1.0, 0.0);
  See(kLower, 1.0, 1.5, -0.08, 0.0);
  const PlaneBitmap lower = Cut(kLower);
  EXPECT_TRUE(lower.OnAt({0.9, -0.04}));
  EXPECT_FALSE(lower.OnAt({1.1, -0.04}));
}

TEST_F(SurfaceJointsTest, ALowFaceStaysThoughPixelsAtItsFootAgreeWithTheGroundToo) {
  See(kFace, 0.0, 3.0, 0.0, 0.06);
  See(kLower, 0.0, 3.0, -1.0, 0.05);
  EXPECT_TRUE(Cut(kFace).OnAt({1.5, 0.025}));
}

}  // namespace
}  // namespace terrace
