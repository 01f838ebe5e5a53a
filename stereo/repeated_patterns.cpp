// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/repeated_patterns.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <tbb/enumerable_thread_specific.h>

#include "core/parallel_for.h"
#include "stereo/aligned_array.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stereo/repeated_patterns.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TERRACE_STEREO_REPEATED_PATTERNS_ONCE_
#define TERRACE_STEREO_REPEATED_PATTERNS_ONCE_
namespace terrace {

constexpr int kTilePx = 8;
/// A window is two blocks of a tile's size, half a tile to the left and half a tile to the right of it.
constexpr int kFirstBlock = kTilePx / 2;
constexpr int kWindowWidth = 2 * kTilePx;
constexpr int kWindowPixels = kWindowWidth * kTilePx;
constexpr int kMaxShift = 32;

/// The rows of pixels that a row of tiles covers.
struct TileRow {
  const std::uint8_t*
      first;  ///< of the first row's first block; kMaxShift pixels before and behind are readable
  std::size_t stride;
  int num_blocks;
};

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class V>
HWY_INLINE V AbsDifference(V a, V b) {
  return hn::Or(hn::SaturatedSub(a, b), hn::SaturatedSub(b, a));
}

/// For each window, how far its pixels are from the mean of their row: the sum.
void ContrastOfWindows(const TileRow& row, int* contrasts) {
  const hn::FixedTag<std::uint8_t, kWindowWidth> d;
  const hn::Repartition<std::uint64_t, decltype(d)> d64;
  const auto total = [&](hn::Vec<decltype(d64)> sums) HWY_ATTR {
    HWY_ALIGN std::uint64_t halves[2];
    hn::Store(sums, d64, halves);
    return static_cast<int>(halves[0] + halves[1]);
  };
  for (int block = 0; block + 1 < row.num_blocks; ++block) {
    auto sums = hn::Zero(d64);
    for (int v = 0; v < kTilePx; ++v) {
      const auto pixels = hn::LoadU(d, row.first + v * row.stride + block * kTilePx);
      const int mean = (total(hn::SumsOf8(pixels)) + kWindowWidth / 2) / kWindowWidth;
      sums = hn::Add(sums, hn::SumsOf8(AbsDifference(pixels, hn::Set(d, static_cast<std::uint8_t>(mean)))));
    }
    contrasts[block] = total(sums);
  }
}

/// For each block, the sum of its differences from what lies `shift` pixels to the right.
void DifferencesOfBlocks(const TileRow& row, int shift, std::uint64_t* differences) {
  const hn::ScalableTag<std::uint8_t> d;
  const hn::Repartition<std::uint64_t, decltype(d)> d64;
  for (int block = 0; block < row.num_blocks; block += static_cast<int>(hn::Lanes(d64))) {
    const std::uint8_t* pixels = row.first + block * kTilePx;
    auto sums = hn::Zero(d64);
    for (int v = 0; v < kTilePx; ++v, pixels += row.stride)
      sums = hn::Add(sums, hn::SumsOf8(AbsDifference(hn::LoadU(d, pixels), hn::LoadU(d, pixels + shift))));
    hn::StoreU(sums, d64, differences + block);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(ContrastOfWindows);
HWY_EXPORT(DifferencesOfBlocks);

namespace {

constexpr int kBehind = 64;  // pixels or sums, which vectors touch
/// Grey levels that a pattern differs by between two repetitions, in the mean.
constexpr int kMinContrast = 6;
/// How much of its contrast a pattern may differ by from its repetition, in percent: periods are not whole
/// pixels, and change where the surface is seen at an angle.
constexpr int kMaxDifferencePercent = 55;

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

class RepeatedPatterns::Scratch {
 public:
  struct OfOneThread {
    AlignedArray<std::uint8_t> pixels;
    AlignedArray<std::uint64_t> differences;
    std::vector<int> contrasts;
  };
  tbb::enumerable_thread_specific<OfOneThread> threads;
};

RepeatedPatterns::RepeatedPatterns() : scratch_(std::make_unique<Scratch>()) {}
RepeatedPatterns::~RepeatedPatterns() = default;

void RepeatedPatterns::Find(const cv::Mat1b& image) {
  rows_ = image.rows / kTilePx;
  columns_ = image.cols < kFirstBlock + kWindowWidth ? 0 : image.cols / kTilePx;
  tiles_.assign(static_cast<std::size_t>(rows_) * columns_, Tile::kUnlike);
  if (columns_ == 0) return;
  ParallelFor(rows_, [&](int row) { FindInRow(image, row); });
  SpreadToNeighbours();
}

void RepeatedPatterns::FindInRow(const cv::Mat1b& image, int row) {
  Scratch::OfOneThread& mine = scratch_->threads.local();
  const int num_blocks = (image.cols - kFirstBlock) / kTilePx, num_windows = num_blocks - 1;
  const std::size_t stride = static_cast<std::size_t>(kMaxShift + image.cols + kMaxShift + kBehind);
  std::uint8_t* const pixels = mine.pixels.Reserve(kTilePx * stride);
  std::fill_n(pixels, kTilePx * stride, std::uint8_t{0});
  for (int v = 0; v < kTilePx; ++v)
    std::memcpy(pixels + v * stride + kMaxShift, image[row * kTilePx + v],
                static_cast<std::size_t>(image.cols));
  const TileRow tile_row = {pixels + kMaxShift + kFirstBlock, stride, num_blocks};

  mine.contrasts.resize(num_windows);
  HWY_DYNAMIC_DISPATCH(ContrastOfWindows)(tile_row, mine.contrasts.data());
  struct Window {
    int block, begin, contrast;
    Repetitions forward, backward;
  };
  std::vector<Window> windows;
  for (int block = 0; block < num_windows; ++block)
    if (mine.contrasts[block] > kMinContrast / 2 * kWindowPixels)
      windows.push_back({block, kFirstBlock + block * kTilePx, mine.contrasts[block], {}, {}});
  if (windows.empty()) return;

  std::uint64_t* const differences = mine.differences.Reserve(num_blocks + kBehind);
  const auto of_window = [&](const Window& window) {
    return static_cast<int>(differences[window.block] + differences[window.block + 1]);
  };
  for (int shift = 1; shift <= kMaxShift; ++shift) {
    HWY_DYNAMIC_DISPATCH(DifferencesOfBlocks)(tile_row, shift, differences);
    for (Window& window : windows)
      if (window.begin + kWindowWidth + shift <= image.cols)
        window.forward.Add(shift, of_window(window), window.contrast);
    HWY_DYNAMIC_DISPATCH(DifferencesOfBlocks)(tile_row, -shift, differences);
    for (Window& window : windows)
      if (window.begin >= shift) window.backward.Add(shift, of_window(window), window.contrast);
  }
  for (const Window& window : windows) {
    const bool twice = window.forward.twice() || window.backward.twice();
    const bool once = window.forward.once() || window.backward.once();
    if (!once && !twice) continue;
    // The tile in the middle of the window; those at the image's edges have none of their own.
    const int first = window.block == 0 ? 0 : window.block + 1;
    const int last = window.block == num_windows - 1 ? columns_ - 1 : window.block + 1;
    std::fill(&tiles_[row * columns_ + first], &tiles_[row * columns_ + last] + 1,
              twice ? Tile::kLikeTwice : Tile::kLikeOnce);
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
#endif  // HWY_ONCE
