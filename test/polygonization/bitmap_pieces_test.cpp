// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/bitmap_pieces.h"

#include <random>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {

cv::Mat1b Bitmap(const std::vector<std::string>& rows) {
  cv::Mat1b bitmap(static_cast<int>(rows.size()), static_cast<int>(rows[0].size()));
  for (int y = 0; y < bitmap.rows; ++y)
    for (int x = 0; x < bitmap.cols; ++x) bitmap(y, x) = rows[y][x] == '#' ? 255 : 0;
  return bitmap;
}

int TwiceSignedArea(const std::vector<cv::Point>& ring) {
  int twice = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const cv::Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return twice;
}

/// The pixels that lie inside by the even-odd rule.
cv::Mat1b PixelsInside(const std::vector<std::vector<cv::Point>>& rings, const cv::Size& size) {
  cv::Mat1b inside = cv::Mat1b::zeros(size);
  for (const std::vector<cv::Point>& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const cv::Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
      // Every upright edge turns the pixels to its right.
      for (int y = std::min(a.y, b.y); y < std::max(a.y, b.y); ++y)
        for (int x = a.x; x < size.width; ++x) inside(y, x) ^= 255;
    }
  }
  return inside;
}

TEST(BitmapPiecesTest, TracesARingAndItsHole) {
  const BitmapPieces pieces(Bitmap({"......", ".####.", ".#..#.", ".####.", "......"}));
  ASSERT_EQ(pieces.pieces().size(), 1U);
  EXPECT_EQ(pieces.pieces()[0].box, cv::Rect(1, 1, 4, 3));
  EXPECT_EQ(pieces.pieces()[0].num_pixels, 10);
  EXPECT_EQ(pieces.pieces()[0].centroid, Eigen::Vector2d(2.5, 2.0));
  const auto rings = pieces.TraceRings(0);
  ASSERT_EQ(rings.size(), 2U);
  EXPECT_EQ(rings[0], (std::vector<cv::Point>{{1, 1}, {5, 1}, {5, 4}, {1, 4}}));
  EXPECT_EQ(TwiceSignedArea(rings[0]), 2 * 12);
  EXPECT_EQ(TwiceSignedArea(rings[1]), -2 * 2);
}

TEST(BitmapPiecesTest, JoinsArmsThatMeetLaterAndKeepsWhatTouchesAtACornerApart) {
  const BitmapPieces pieces(Bitmap({"#.#.#.", "#.#.#.", "###..#"}));
  ASSERT_EQ(pieces.pieces().size(), 3U);
  EXPECT_EQ(pieces.PieceAt(0, 0), 0);
  EXPECT_EQ(pieces.PieceAt(2, 0), 0);
  EXPECT_EQ(pieces.PieceAt(4, 1), 1);
  EXPECT_EQ(pieces.PieceAt(5, 2), 2);
  EXPECT_EQ(pieces.PieceAt(1, 0), -1);
  EXPECT_EQ(pieces.PieceAt(6, 2), -1);
  EXPECT_EQ(pieces.PieceAt(0, -1), -1);
  EXPECT_EQ(pieces.PieceAt(0, 3), -1);
}

TEST(BitmapPiecesTest, ReachesTheBordersOfTheBitmap) {
  const BitmapPieces pieces(Bitmap({"###", "###"}));
  ASSERT_EQ(pieces.TraceRings(0).size(), 1U);
  EXPECT_EQ(pieces.TraceRings(0)[0], (std::vector<cv::Point>{{0, 0}, {3, 0}, {3, 2}, {0, 2}}));
}

TEST(BitmapPiecesTest, HasNoPiecesWhereNothingIsSet) {
  EXPECT_TRUE(BitmapPieces(cv::Mat1b::zeros(3, 4)).pieces().empty());
  EXPECT_EQ(BitmapPieces().PieceAt(0, 0), -1);
}

TEST(BitmapPiecesTest, AgreesWithComponentsAndCountsOfSinglePixels) {
  std::mt19937 random(1);
  for (const double share : {0.2, 0.5, 0.6, 0.9}) {
    cv::Mat1b bitmap(40, 61), other(bitmap.size());
    for (std::uint8_t& pixel : bitmap) pixel = std::bernoulli_distribution(share)(random) ? 255 : 0;
    for (std::uint8_t& pixel : other) pixel = std::bernoulli_distribution(0.5)(random) ? 255 : 0;
    cv::Mat1i labels, stats;
    cv::Mat1d centroids;
    const int num = cv::connectedComponentsWithStats(bitmap, labels, stats, centroids, 4, CV_32S);
    const BitmapPieces found(bitmap);
    const std::vector<int> num_set = found.CountSet(other);
    ASSERT_EQ(found.pieces().size(), static_cast<std::size_t>(num - 1));
    for (int i = 0; i < num - 1; ++i) {
      // Both number the pieces by their first pixels.
      const int label = i + 1;
      const BitmapPieces::Piece& piece = found.pieces()[i];
      EXPECT_EQ(piece.num_pixels, stats(label, cv::CC_STAT_AREA));
      EXPECT_EQ(piece.box, cv::Rect(stats(label, cv::CC_STAT_LEFT), stats(label, cv::CC_STAT_TOP),
                                    stats(label, cv::CC_STAT_WIDTH), stats(label, cv::CC_STAT_HEIGHT)));
      EXPECT_NEAR(piece.centroid.x(), centroids(label, 0), 1e-9);
      EXPECT_NEAR(piece.centroid.y(), centroids(label, 1), 1e-9);
      EXPECT_EQ(num_set[i], cv::countNonZero((labels == label) & other));
      const auto rings = found.TraceRings(i);
      EXPECT_EQ(cv::countNonZero(PixelsInside(rings, bitmap.size()) != (labels == label)), 0);
      int twice_area = 0;
      for (const std::vector<cv::Point>& ring : rings) twice_area += TwiceSignedArea(ring);
      EXPECT_EQ(twice_area, 2 * piece.num_pixels);
    }
    for (int y = 0; y < bitmap.rows; ++y)
      for (int x = 0; x < bitmap.cols; ++x) ASSERT_EQ(found.PieceAt(x, y), labels(y, x) - 1);
  }
}

}  // namespace
}  // namespace terrace
