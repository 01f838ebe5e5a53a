// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/outline_tracer.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace terrace {
namespace {

using Holds = std::function<bool(const Eigen::Vector2d&)>;

/// Pixels of 1 cm over [-0.1, width] x [-0.1, height].
PlaneBitmap Draw(double width, double height, const Holds& on, const Holds& barred = {}) {
  PlaneBitmap bitmap;
  bitmap.low = {-0.1, -0.1};
  const cv::Size size(static_cast<int>(std::lround((width + 0.2) / 0.01)),
                      static_cast<int>(std::lround((height + 0.2) / 0.01)));
  bitmap.on = cv::Mat1b::zeros(size);
  bitmap.barred = cv::Mat1b::zeros(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector2d p = bitmap.CentreOf(x, y);
      if (barred && barred(p))
        bitmap.barred(y, x) = 255;
      else if (on(p))
        bitmap.on(y, x) = 255;
    }
  }
  return bitmap;
}

/// A rectangle turned by `angle` about its centre.
Holds Rectangle(double width, double height, double angle, const Eigen::Vector2d& centre) {
  return [=](const Eigen::Vector2d& p) {
    const Eigen::Vector2d d = Eigen::Rotation2Dd(-angle) * (p - centre);
    return std::abs(d.x()) < 0.5 * width && std::abs(d.y()) < 0.5 * height;
  };
}

TEST(OutlineTracerTest, TracesARectangleByItsFourCorners) {
  OutlineTracer tracer({}, Draw(1, 1, Rectangle(0.6, 0.3, 0.0, {0.5, 0.5})));
  const std::vector<TracedPiece> pieces = tracer.Trace();
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_EQ(pieces[0].outline.size(), 4U);
  EXPECT_NEAR(pieces[0].area_m2, 0.18, 0.001);
  EXPECT_GT(SignedArea(pieces[0].outline), 0.0);
  EXPECT_NEAR((pieces[0].centroid - Eigen::Vector2d(0.5, 0.5)).norm(), 0.0, 0.001);
  EXPECT_NEAR(pieces[0].support, 1.0, 1e-9);
}

TEST(OutlineTracerTest, FindsSlantedEdgesWithinAPixel) {
  for (const double angle : {0.1, 0.3, 0.7, 1.2}) {
    OutlineTracer tracer({}, Draw(1, 1, Rectangle(0.6, 0.3, angle, {0.5, 0.5})));
    const std::vector<TracedPiece> pieces = tracer.Trace();
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_LE(pieces[0].outline.size(), 8U) << "at an angle of " << angle;
    for (std::size_t i = 0; i < pieces[0].outline.size(); ++i) {
      const Eigen::Vector2d middle =
          0.5 * (pieces[0].outline[i] + pieces[0].outline[(i + 1) % pieces[0].outline.size()]);
      const Eigen::Vector2d d = Eigen::Rotation2Dd(-angle) * (middle - Eigen::Vector2d(0.5, 0.5));
      const double beyond = std::max(std::abs(d.x()) - 0.3, std::abs(d.y()) - 0.15);
      EXPECT_NEAR(beyond, 0.0, 0.006) << "at an angle of " << angle;
    }
  }
}

TEST(OutlineTracerTest, KeepsRealHolesAndClosesGapsInTheData) {
  const auto hole = [](const Eigen::Vector2d& p) {
    return p.x() > 0.3 && p.x() < 0.5 && p.y() > 0.3 && p.y() < 0.6;
  };
  const auto gap = [](const Eigen::Vector2d& p) { return p.x() > 0.7 && p.x() < 0.74; };
  const auto square = Rectangle(1, 1, 0, {0.5, 0.5});
  OutlineTracer tracer(
      {}, Draw(1, 1, [&](const Eigen::Vector2d& p) { return square(p) && !hole(p) && !gap(p); }));
  const std::vector<TracedPiece> pieces = tracer.Trace();
  ASSERT_EQ(pieces.size(), 1U);
  ASSERT_EQ(pieces[0].holes.size(), 1U);
  EXPECT_LT(SignedArea(pieces[0].holes[0]), 0.0);
  EXPECT_NEAR(-SignedArea(pieces[0].holes[0]), 0.06, 0.004);
  EXPECT_NEAR(pieces[0].area_m2, 0.94, 0.01);
  EXPECT_NEAR(pieces[0].support, 0.96, 0.01);
}

TEST(OutlineTracerTest, NeverFillsWhatWasSeenThroughHoweverSmall) {
  const auto square = Rectangle(1, 1, 0, {0.5, 0.5});
  const auto hole = Rectangle(0.05, 0.05, 0, {0.5, 0.5});
  const auto slit = Rectangle(0.02, 2.0, 0, {0.8, 0.5});
  OutlineTracer tracer({}, Draw(1, 1, square, [&](const Eigen::Vector2d& p) { return hole(p) || slit(p); }));
  const std::vector<TracedPiece> pieces = tracer.Trace();
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(tracer.PieceAt({0.5, 0.5}), -1);
  EXPECT_EQ(tracer.PieceAt({0.8, 0.3}), -1);
  EXPECT_NE(tracer.PieceAt({0.7, 0.3}), tracer.PieceAt({0.9, 0.3}));
}

TEST(OutlineTracerTest, KeepsPiecesApartAcrossAGap) {
  const auto left = Rectangle(0.4, 0.4, 0.0, {0.5, 0.5}), right = Rectangle(0.4, 0.4, 0.0, {1.0, 0.5});
  OutlineTracer tracer({}, Draw(2, 1, [&](const Eigen::Vector2d& p) { return left(p) || right(p); }));
  EXPECT_EQ(tracer.Trace().size(), 2U);
  EXPECT_EQ(tracer.PieceAt({0.5, 0.5}), 0);
  EXPECT_EQ(tracer.PieceAt({1.0, 0.5}), 1);
  EXPECT_EQ(tracer.PieceAt({0.75, 0.5}), -1);
}

TEST(OutlineTracerTest, GivesSimpleRingsForAnythingScattered) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(0.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Holds> rectangles;
    for (int i = 0; i < 300; ++i) {
      const double width = 0.1 * anywhere(random), height = 0.1 * anywhere(random);
      const double angle = 6.0 * anywhere(random), x = anywhere(random), y = anywhere(random);
      rectangles.push_back(Rectangle(width, height, angle, {x, y}));
    }
    OutlineTracer tracer({}, Draw(1, 1, [&](const Eigen::Vector2d& p) {
                           return std::any_of(rectangles.begin(), rectangles.end(),
                                              [&](const Holds& holds) { return holds(p); });
                         }));
    for (const TracedPiece& piece : tracer.Trace()) {
      std::vector<const Ring2*> rings{&piece.outline};
      for (const Ring2& hole : piece.holes) {
        rings.push_back(&hole);
        EXPECT_LT(SignedArea(hole), 0.0);
      }
      EXPECT_GT(SignedArea(piece.outline), 0.0);
      EXPECT_TRUE(AreSimple(rings));
      EXPECT_GT(piece.area_m2, 0.0);
    }
  }
}

TEST(OutlineTracerTest, ARaggedPieceIsSimplifiedFurtherWhenItHasTooManyVertices) {
  const auto num_vertices = [](int max_vertices) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> anywhere(0.0, 1.0);
    std::vector<double> teeth;
    for (int i = 0; i < 80; ++i) teeth.push_back(0.1 + 0.1 * anywhere(random));
    OutlineSettings settings;
    settings.max_vertices = max_vertices;
    // Teeth of random length along one side, as rows of far ground leave them.
    OutlineTracer tracer(settings, Draw(4, 1, [&](const Eigen::Vector2d& p) {
                           if (p.x() < 0.0 || p.x() > 4.0 || p.y() < 0.0) return false;
                           const double along = p.x() / 0.05;
                           const auto tooth = static_cast<std::size_t>(along);
                           const bool in_tooth = tooth < teeth.size() && along - double(tooth) < 0.6;
                           return p.y() < 0.5 + (in_tooth ? teeth[tooth] : 0.0);
                         }));
    const std::vector<TracedPiece> pieces = tracer.Trace();
    EXPECT_EQ(pieces.size(), 1U);
    EXPECT_TRUE(AreSimple({&pieces[0].outline}));
    return pieces[0].outline.size();
  };
  EXPECT_GT(num_vertices(5000), 60U);
  EXPECT_LE(num_vertices(20), 20U);
}

}  // namespace
}  // namespace terrace
