// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/outline_tracer.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace terrace {
namespace {

/// Leaves of 2 cm, as the octree gives them, over a rectangle turned by `angle` about its centre.
void FillRectangle(double width, double height, double angle, const Eigen::Vector2d& centre,
                   OutlineTracer* tracer) {
  const Eigen::Vector2d x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
  constexpr double kLeaf = 0.02;
  for (double a = -0.5 * width; a < 0.5 * width - 1e-9; a += kLeaf)
    for (double b = -0.5 * height; b < 0.5 * height - 1e-9; b += kLeaf)
      tracer->Fill(centre + (a + 0.5 * kLeaf) * x + (b + 0.5 * kLeaf) * y, 0.5 * kLeaf * x, 0.5 * kLeaf * y);
}

TEST(OutlineTracerTest, TracesARectangleByItsFourCorners) {
  OutlineTracer tracer({}, {0, 0}, {1, 1});
  FillRectangle(0.6, 0.3, 0.0, {0.5, 0.5}, &tracer);
  const std::vector<TracedPiece> shapes = tracer.Trace();
  ASSERT_EQ(shapes.size(), 1U);
  EXPECT_EQ(shapes[0].outline.size(), 4U);
  EXPECT_NEAR(shapes[0].area_m2, 0.18, 0.01);
  EXPECT_GT(SignedArea(shapes[0].outline), 0.0);
  EXPECT_NEAR((shapes[0].centroid - Eigen::Vector2d(0.5, 0.5)).norm(), 0.0, 0.006);
  EXPECT_NEAR(shapes[0].support, 1.0, 0.01);
}

TEST(OutlineTracerTest, FindsSlantedEdgesWithinAPixel) {
  for (const double angle : {0.1, 0.3, 0.7, 1.2}) {
    OutlineTracer tracer({}, {0, 0}, {1, 1});
    FillRectangle(0.6, 0.3, angle, {0.5, 0.5}, &tracer);
    const std::vector<TracedPiece> shapes = tracer.Trace();
    ASSERT_EQ(shapes.size(), 1U);
    const Eigen::Vector2d x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
    for (const Eigen::Vector2d& p : shapes[0].outline) {
      const Eigen::Vector2d d = p - Eigen::Vector2d(0.5, 0.5);
      const double beyond = std::max(std::abs(d.dot(x)) - 0.3, std::abs(d.dot(y)) - 0.15);
      EXPECT_NEAR(beyond, 0.0, 0.012) << "at an angle of " << angle;
    }
  }
}

TEST(OutlineTracerTest, KeepsRealHolesAndClosesGapsInTheData) {
  OutlineTracer tracer({}, {0, 0}, {1, 1});
  for (double x = 0.01; x < 1.0; x += 0.02) {
    for (double y = 0.01; y < 1.0; y += 0.02) {
      const bool hole = x > 0.3 && x < 0.5 && y > 0.3 && y < 0.6;
      const bool gap = x > 0.7 && x < 0.74;
      if (!hole && !gap) tracer.Fill({x, y}, {0.01, 0}, {0, 0.01});
    }
  }
  const std::vector<TracedPiece> shapes = tracer.Trace();
  ASSERT_EQ(shapes.size(), 1U);
  ASSERT_EQ(shapes[0].holes.size(), 1U);
  EXPECT_LT(SignedArea(shapes[0].holes[0]), 0.0);
  EXPECT_NEAR(-SignedArea(shapes[0].holes[0]), 0.06, 0.004);
  EXPECT_NEAR(shapes[0].area_m2, 0.94, 0.01);
  EXPECT_NEAR(shapes[0].support, 0.96, 0.01);
}

TEST(OutlineTracerTest, KeepsPiecesApartAcrossAGap) {
  OutlineTracer tracer({}, {0, 0}, {2, 1});
  FillRectangle(0.4, 0.4, 0.0, {0.5, 0.5}, &tracer);
  FillRectangle(0.4, 0.4, 0.0, {1.0, 0.5}, &tracer);
  EXPECT_EQ(tracer.Trace().size(), 2U);
  EXPECT_EQ(tracer.PieceAt({0.5, 0.5}), 0);
  EXPECT_EQ(tracer.PieceAt({1.0, 0.5}), 1);
  EXPECT_EQ(tracer.PieceAt({0.75, 0.5}), -1);
}

TEST(OutlineTracerTest, GivesSimpleRingsForAnythingScattered) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(0.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    OutlineTracer tracer({}, {0, 0}, {1, 1});
    for (int i = 0; i < 300; ++i) {
      const double angle = 6.0 * anywhere(random);
      const Eigen::Vector2d x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
      tracer.Fill({anywhere(random), anywhere(random)}, 0.05 * anywhere(random) * x,
                  0.05 * anywhere(random) * y);
    }
    for (const TracedPiece& shape : tracer.Trace()) {
      std::vector<const Ring2*> rings{&shape.outline};
      for (const Ring2& hole : shape.holes) {
        rings.push_back(&hole);
        EXPECT_LT(SignedArea(hole), 0.0);
      }
      EXPECT_GT(SignedArea(shape.outline), 0.0);
      EXPECT_TRUE(AreSimple(rings));
      EXPECT_GT(shape.area_m2, 0.0);
    }
  }
}

TEST(OutlineTracerTest, ARaggedShapeIsSimplifiedFurtherWhenItHasTooManyVertices) {
  const auto num_vertices = [](int max_vertices) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> anywhere(0.0, 1.0);
    OutlineSettings settings;
    settings.max_vertices = max_vertices;
    OutlineTracer tracer(settings, {0, -1}, {4, 1});
    FillRectangle(4.0, 0.5, 0.0, {2.0, 0.0}, &tracer);
    // Teeth of random length along one side, as rows of far ground leave them.
    for (int i = 0; i < 80; ++i)
      tracer.Fill({0.05 * i, 0.25}, {0.015, 0.0}, {0.0, 0.05 + 0.1 * anywhere(random)});
    const std::vector<TracedPiece> shapes = tracer.Trace();
    EXPECT_EQ(shapes.size(), 1U);
    EXPECT_TRUE(AreSimple({&shapes[0].outline}));
    return shapes[0].outline.size();
  };
  EXPECT_GT(num_vertices(5000), 60U);
  EXPECT_LE(num_vertices(20), 20U);
}

TEST(OutlineTracerTest, CoarsensRatherThanAllocateWithoutBound) {
  OutlineTracer tracer({}, {0, 0}, {10000, 10000});
  tracer.Fill({5000, 5000}, {50, 0}, {0, 30});
  const std::vector<TracedPiece> pieces = tracer.Trace();
  ASSERT_EQ(pieces.size(), 1U);
  // Four million pixels over the square of 10 km are about 5 m wide; they double until they fit.
  constexpr double kPixel_m = 10.24;
  EXPECT_NEAR(pieces[0].area_m2, 100.0 * 60.0, 2.0 * (100.0 + 60.0) * kPixel_m);
  EXPECT_NEAR((pieces[0].centroid - Eigen::Vector2d(5000, 5000)).norm(), 0.0, kPixel_m);
}

}  // namespace
}  // namespace terrace
