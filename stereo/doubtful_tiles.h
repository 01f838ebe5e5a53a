// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Where nothing that was searched fits: what is nearer than the search goes, or is not in the right image at
/// all, still has a best disparity everywhere, and neighbours make a surface of them. But there the best is
/// poor, or the last one of the search.
class DoubtfulTiles {
 public:
  static constexpr int kTilePx = 8;

  /// Forgets all rows.
  void Begin(const cv::Size& size);
  /// A row of a match; the rows of one row of tiles from top to bottom, by one thread.
  /// @param disparity  the winners that both views agree on; NaN = unknown
  /// @param best_sums  of the costs along the paths
  /// @param max_sum    a greater one is poor
  /// @param last       a disparity from this on is the last of the search
  void AddRow(int v, const float* disparity, const std::uint8_t* best_sums, int max_sum, float last);

  /// Counts anew how many are known, in an image of the size of the match from which some were taken.
  void Recount(const cv::Mat1f& disparity);

  /// Makes all disparities unknown in tiles where a good part of the known ones is poor or the last, or
  /// hardly any was known.
  /// @param scale  pixels of this image to one of the match
  void Forget(int scale, cv::Mat1f& disparity) const;

  /// The share of all pixels of the image that are in such tiles.
  double share() const;
  /// The share of all pixels whose best disparity is the last of the search.
  double share_at_limit() const;

 private:
  int NumPixels(int row, int column) const;
  bool IsDoubtful(int row, int column) const;

  cv::Size size_;
  /// Pixels of each tile: all, those with a disparity, those that kept it, poor ones, last ones.
  cv::Mat1b num_seen_, num_known_, num_kept_, num_poor_, num_last_;
};

}  // namespace terrace
