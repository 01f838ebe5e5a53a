// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/repeated_patterns.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/parallel_for.h"

namespace terrace {
namespace {

constexpr int kTilePx = 8;
constexpr int kWindowWidth = 16;  // as high as a tile
constexpr int kWindowPixels = kWindowWidth * kTilePx;
constexpr int kMaxShift = 32;
/// Grey levels that a pattern differs by between two repetitions, in the mean.
constexpr int kMinContrast = 6;
/// How much of its contrast a pattern may differ by from its repetition, in percent: periods are not whole
/// pixels, and change where the surface is seen at an angle.
constexpr int kMaxDifferencePercent = 55;

/// Sum over the window whose first pixel is (u, v) of how far pixels are from the mean of their row.
int ContrastWithin(const cv::Mat1b& image, int u, int v) {
  int sum = 0;
  for (int row = v; row < v + kTilePx; ++row) {
    const std::uint8_t* pixels = image[row] + u;
    int total = 0, difference = 0;
    for (int i = 0; i < kWindowWidth; ++i) total += pixels[i];
    for (int i = 0; i < kWindowWidth; ++i) difference += std::abs(kWindowWidth * pixels[i] - total);
    sum += difference / kWindowWidth;
  }
  return sum;
}

/// What shifts of a window in one direction, each longer than the one before, have shown.
class Repetitions {
 public:
  /// @param difference  sum over the window between the image and the shifted one
  void Add(int shift, int difference, int contrast_within) {
    const int contrast = std::min(hump_, contrast_within * 3 / 2);
    if (shift > 1 && hump_ > kMinContrast * kWindowPixels &&
        difference * 100 < contrast * kMaxDifferencePercent)
      alike_ |= std::uint64_t{1} << shift;
    hump_ = std::max(hump_, difference);
  }
  bool once() const { return alike_ != 0; }
  bool twice() const {
    for (int shift = 4; shift <= kMaxShift; ++shift)
      if (Alike(shift) && (Alike(shift / 2) || Alike((shift + 1) / 2))) return true;
    return false;
  }

 private:
  bool Alike(int shift) const { return (alike_ >> shift & 1) != 0; }

  int hump_ = 0;             ///< greatest difference so far
  std::uint64_t alike_ = 0;  ///< bit i: after a shift by i pixels the image looks the same
};

}  // namespace

void RepeatedPatterns::Find(const cv::Mat1b& image) {
  rows_ = image.rows / kTilePx;
  columns_ = image.cols < kWindowWidth ? 0 : image.cols / kTilePx;
  tiles_.assign(static_cast<std::size_t>(rows_) * columns_, Tile::kUnlike);
  if (columns_ == 0) return;
  ParallelFor(rows_, [&](int row) { FindInRow(image, row); });
  SpreadToNeighbours();
}

void RepeatedPatterns::FindInRow(const cv::Mat1b& image, int row) {
  struct Window {
    int column, begin, contrast;
    Repetitions forward, backward;
  };
  std::vector<Window> windows;
  for (int column = 0; column < columns_; ++column) {
    const int begin =
        std::clamp(column * kTilePx - (kWindowWidth - kTilePx) / 2, 0, image.cols - kWindowWidth);
    const int contrast = ContrastWithin(image, begin, row * kTilePx);
    if (contrast > kMinContrast / 2 * kWindowPixels) windows.push_back({column, begin, contrast, {}, {}});
  }
  if (windows.empty()) return;
  std::vector<int> differences(image.cols), sums(image.cols + 1);
  for (int shift = 1; shift <= std::min(kMaxShift, image.cols - kWindowWidth); ++shift) {
    const int width = image.cols - shift;
    std::fill_n(differences.begin(), width, 0);
    for (int v = row * kTilePx; v < (row + 1) * kTilePx; ++v) {
      const std::uint8_t *pixels = image[v], *shifted = pixels + shift;
      for (int u = 0; u < width; ++u) differences[u] += std::abs(pixels[u] - shifted[u]);
    }
    for (int u = 0; u < width; ++u) sums[u + 1] = sums[u] + differences[u];
    for (Window& window : windows) {
      const auto add = [&](int begin, Repetitions& repetitions) {
        if (begin >= 0 && begin + kWindowWidth <= width)
          repetitions.Add(shift, sums[begin + kWindowWidth] - sums[begin], window.contrast);
      };
      add(window.begin, window.forward);
      add(window.begin - shift, window.backward);
    }
  }
  for (const Window& window : windows) {
    const bool twice = window.forward.twice() || window.backward.twice();
    const bool once = window.forward.once() || window.backward.once();
    tiles_[row * columns_ + window.column] = twice  ? Tile::kLikeTwice
                                             : once ? Tile::kLikeOnce
                                                    : Tile::kUnlike;
  }
}

void RepeatedPatterns::SpreadToNeighbours() {
  std::vector<std::pair<int, int>> open;  // row and column
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column)
      if (tiles_[row * columns_ + column] == Tile::kLikeTwice) open.emplace_back(row, column);
  while (!open.empty()) {
    const auto [row, column] = open.back();
    open.pop_back();
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows_ - 1); ++r)
      for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c) {
        Tile& tile = tiles_[r * columns_ + c];
        if (tile != Tile::kLikeOnce) continue;
        tile = Tile::kLikeTwice;
        open.emplace_back(r, c);
      }
  }
}

int RepeatedPatterns::NumPixels(int v, int begin, int end, int scale) const {
  const int tile_px = kTilePx * scale, row = v / tile_px;
  if (row >= rows_) return 0;
  int count = 0;
  for (int column = begin / tile_px; column < columns_ && column * tile_px < end; ++column)
    if (tiles_[row * columns_ + column] == Tile::kLikeTwice)
      count += std::min(end, (column + 1) * tile_px) - std::max(begin, column * tile_px);
  return count;
}

}  // namespace terrace
