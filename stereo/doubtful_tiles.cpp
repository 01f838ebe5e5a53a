// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/doubtful_tiles.h"

#include <algorithm>

#include <opencv2/core.hpp>

#include "core/parallel_for.h"
#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

/// Of the winners of chance half are poor, of right ones hardly any: one in three is enough.
constexpr int kPoorOf = 3;
/// Where not even one pixel in so many is known, neighbours know no better.
constexpr int kKnownOf = 8;

}  // namespace

void DoubtfulTiles::Begin(const cv::Size& size) {
  size_ = size;
  const cv::Size tiles((size.width + kTilePx - 1) / kTilePx, (size.height + kTilePx - 1) / kTilePx);
  for (cv::Mat1b* counts : {&num_seen_, &num_known_, &num_kept_, &num_poor_, &num_last_}) {
    counts->create(tiles);
    counts->setTo(0);
  }
}

void DoubtfulTiles::AddRow(int v, const float* disparity, const std::uint8_t* best_sums, int max_sum,
                           float last) {
  std::uint8_t* seen = num_seen_[v / kTilePx];
  std::uint8_t* known = num_known_[v / kTilePx];
  std::uint8_t* kept = num_kept_[v / kTilePx];
  std::uint8_t* poor = num_poor_[v / kTilePx];
  std::uint8_t* at_limit = num_last_[v / kTilePx];
  for (int begin = 0, column = 0; begin < size_.width; begin += kTilePx, ++column) {
    const int end = std::min(begin + kTilePx, size_.width);
    int n = 0, num_poor = 0, num_last = 0;
    for (int u = begin; u < end; ++u) {
      const bool is_known = disparity[u] >= 0.0f;  // not NaN
      const bool is_last = disparity[u] >= last;
      n += is_known;
      num_last += is_last;
      num_poor += is_last | (is_known & (best_sums[u] > max_sum));
    }
    seen[column] = static_cast<std::uint8_t>(seen[column] + end - begin);
    known[column] = static_cast<std::uint8_t>(known[column] + n);
    kept[column] = known[column];
    poor[column] = static_cast<std::uint8_t>(poor[column] + num_poor);
    at_limit[column] = static_cast<std::uint8_t>(at_limit[column] + num_last);
  }
}

int DoubtfulTiles::NumPixels(int row, int column) const {
  return std::min(kTilePx, size_.width - column * kTilePx) * std::min(kTilePx, size_.height - row * kTilePx);
}

void DoubtfulTiles::Recount(const cv::Mat1f& disparity) {
  for (int row = 0; row < num_kept_.rows; ++row)
    for (int column = 0; column < num_kept_.cols; ++column) {
      const int left = column * kTilePx, right = std::min(left + kTilePx, size_.width);
      const int top = row * kTilePx, bottom = std::min(top + kTilePx, size_.height);
      int n = 0;
      for (int v = top; v < bottom; ++v)
        for (int u = left; u < right; ++u) n += disparity(v, u) >= 0.0f;  // not NaN
      num_kept_(row, column) = static_cast<std::uint8_t>(n);
    }
}

bool DoubtfulTiles::IsDoubtful(int row, int column) const {
  const int num_known = num_known_(row, column);
  return kPoorOf * num_poor_(row, column) > num_known ||
         kKnownOf * num_kept_(row, column) < num_seen_(row, column);
}

void DoubtfulTiles::Forget(int scale, cv::Mat1f& disparity) const {
  const int tile_px = scale * kTilePx;
  ParallelFor(num_known_.rows, [&](int row) {
    const int top = row * tile_px, bottom = std::min(top + tile_px, disparity.rows);
    for (int column = 0; column < num_known_.cols; ++column) {
      if (!IsDoubtful(row, column)) continue;
      const int left = column * tile_px, right = std::min(left + tile_px, disparity.cols);
      for (int v = top; v < bottom; ++v)
        std::fill(disparity[v] + left, disparity[v] + right, kUnknownDisparity);
    }
  });
}

double DoubtfulTiles::share() const {
  int num_pixels = 0;
  for (int row = 0; row < num_known_.rows; ++row)
    for (int column = 0; column < num_known_.cols; ++column)
      if (IsDoubtful(row, column)) num_pixels += NumPixels(row, column);
  return num_pixels / std::max(1.0, static_cast<double>(size_.area()));
}

double DoubtfulTiles::share_at_limit() const {
  return cv::sum(num_last_)[0] / std::max(1.0, static_cast<double>(size_.area()));
}

}  // namespace terrace
