// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// Where an image repeats itself along the row, as gratings, slats and woven carpets do: the other image
/// agrees with it at several disparities, and only what lies around such a place tells which is right.
class RepeatedPatterns {
 public:
  RepeatedPatterns();
  ~RepeatedPatterns();

  /// Looks at tiles of the image: one repeats itself when a window around it looks the same after one and
  /// after two periods, to the left or to the right, and different between; and so does a neighbour of such
  /// a tile that looks the same after one. Periods of 2 to 16 pixels are found, none in images less than 20
  /// wide.
  void Find(const cv::Mat1b& image);

  /// How many of the pixels [begin, end) of a row repeat themselves.
  /// @param scale  pixels of that row to one of the image
  int NumPixels(int v, int begin, int end, int scale) const;

 private:
  class Scratch;
  enum class Tile : std::uint8_t { kUnlike, kLikeOnce, kLikeTwice };

  void FindInRow(const cv::Mat1b& image, int row);
  void SpreadToNeighbours();

  int rows_ = 0, columns_ = 0;
  std::vector<Tile> tiles_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace terrace
