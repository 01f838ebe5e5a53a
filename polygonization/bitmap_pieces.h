// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace terrace {

/// The pieces of a bitmap whose pixels hang together by their sides, kept as the runs of set pixels in its
/// rows: what is asked of them costs as much as they have runs, not pixels.
class BitmapPieces {
 public:
  struct Piece {
    cv::Rect box;  ///< the least that holds it
    int num_pixels = 0;
    Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< mean of its pixels' (x, y)
  };

  BitmapPieces() = default;
  /// @param bitmap  0 or 255 everywhere
  explicit BitmapPieces(const cv::Mat1b& bitmap);

  /// In the order of their first pixels, row by row.
  const std::vector<Piece>& pieces() const { return pieces_; }
  /// Index of the piece at a pixel; -1 where there is none, also outside the bitmap.
  int PieceAt(int x, int y) const;
  /// How many pixels of each piece are set in another bitmap of the same size.
  std::vector<int> CountSet(const cv::Mat1b& bitmap) const;
  /// The edges of a piece as closed rings along the corners of pixels, (0, 0) being the outer corner of pixel
  /// (0, 0), with the piece on the left (y grows upwards): counter-clockwise outside, clockwise around holes.
  /// Only corners where the direction changes. No two pixels of the bitmap may touch at a corner only, or a
  /// ring may touch itself.
  std::vector<std::vector<cv::Point>> TraceRings(int piece) const;

 private:
  /// Set pixels [begin, end) of row y.
  struct Run {
    int y, begin, end, piece;
  };
  void FindRuns(const cv::Mat1b& bitmap);
  void FindPieces();
  /// Calls `use(begin, end)` for what of [begin, end) is not set in row y.
  template <typename Use>
  void ForEachGap(int y, int begin, int end, const Use& use) const;

  std::vector<Run> runs_;       // row by row, from left to right
  std::vector<int> first_run_;  // of each row, and one more
  std::vector<Piece> pieces_;
};

}  // namespace terrace
