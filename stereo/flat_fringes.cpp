// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/flat_fringes.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

/// Greatest minus least grey level of 3x3 pixels of the half image that only noise tells apart.
constexpr double kFlatRange_grey = 5.0;
/// Half pixels that windows and paths carry a disparity.
constexpr std::uint8_t kReach = 14;
constexpr std::uint8_t kNotReached = 255;
/// A pixel at the end of the flat place belongs to it when its grey level is so near to the place's.
constexpr int kSameGrey = 8;

/// 255 where 3x3 pixels around are alike.
cv::Mat1b FlatPixels(const cv::Mat1b& half_image) {
  cv::Mat1b greatest, least, flat;
  const cv::Mat kernel = cv::Mat1b::ones(3, 3);
  cv::dilate(half_image, greatest, kernel);
  cv::erode(half_image, least, kernel);
  cv::subtract(greatest, least, greatest);
  cv::compare(greatest, kFlatRange_grey, flat, cv::CMP_LE);
  return flat;
}

/// 255 where none of the four pixels that a half pixel stands for has a disparity.
cv::Mat1b UnknownPixels(const cv::Mat1f& disparity, const cv::Size& half_size) {
  cv::Mat1b unknown(half_size);
  std::vector<std::uint8_t> both(static_cast<std::size_t>(disparity.cols) + 1, 255);
  for (int y = 0; y < half_size.height; ++y) {
    const float* const above = disparity[2 * y];
    const float* const below = disparity[std::min(2 * y + 1, disparity.rows - 1)];
    // What is not a number does not equal itself; so the compiler makes vectors of this.
    for (int u = 0; u < disparity.cols; ++u)
      both[static_cast<std::size_t>(u)] = (above[u] != above[u]) & (below[u] != below[u]) ? 255 : 0;
    std::uint8_t* const row = unknown[y];
    for (int x = 0; x < half_size.width; ++x)
      row[x] = both[static_cast<std::size_t>(2 * x)] & both[static_cast<std::size_t>(2 * x + 1)];
  }
  return unknown;
}

/// The first row with a pixel that is not 0, and the one after the last; {0, 0} where there is none.
std::pair<int, int> RowsWithAny(const cv::Mat1b& image) {
  const auto any = [&](int y) { return cv::countNonZero(image.row(y)) > 0; };
  int begin = 0, end = image.rows;
  while (begin < end && !any(begin)) ++begin;
  while (end > begin && !any(end - 1)) --end;
  return begin < end ? std::pair(begin, end) : std::pair(0, 0);
}

/// Steps, at most kReach, from a seed to each flat pixel, over flat pixels only, in rows [begin, end).
cv::Mat1b StepsFrom(const cv::Mat1b& seeds, const cv::Mat1b& flat, int begin, int end) {
  // A border, so that every pixel has neighbours.
  cv::Mat1b bordered(flat.rows + 2, flat.cols + 2, kNotReached);
  cv::Mat1b steps = bordered(cv::Rect(1, 1, flat.cols, flat.rows));
  steps.setTo(0, seeds);
  const auto step_from = [](const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* pixel) {
    const std::uint8_t least = std::min(*a, *b);
    if (least < kReach) *pixel = std::min(*pixel, static_cast<std::uint8_t>(least + 1));
  };
  // Down and up again; a way that winds more than once is not taken.
  const auto width = static_cast<int>(bordered.step);
  for (int y = begin; y < end; ++y) {
    std::uint8_t* const row = steps[y];
    const std::uint8_t* const is_flat = flat[y];
    for (int x = 0; x < steps.cols; ++x)
      if (is_flat[x] != 0) step_from(row + x - 1, row + x - width, row + x);
  }
  for (int y = end - 1; y >= begin; --y) {
    std::uint8_t* const row = steps[y];
    const std::uint8_t* const is_flat = flat[y];
    for (int x = steps.cols - 1; x >= 0; --x)
      if (is_flat[x] != 0) step_from(row + x + 1, row + x + width, row + x);
  }
  return steps;
}

}  // namespace

void ForgetFlatFringes(const cv::Mat1b& image, const cv::Mat1b& half_image, cv::Mat1f& disparity,
                       cv::Mat1f& sigma) {
  TERRACE_CHECK(image.size() == disparity.size() && sigma.size() == disparity.size(), image.cols, image.rows);
  const cv::Mat1b flat = FlatPixels(half_image);
  cv::Mat1b seeds = UnknownPixels(disparity, half_image.size()) & flat;
  // Not from the holes that every flat surface has.
  cv::erode(seeds, seeds, cv::Mat1b::ones(7, 7));
  const auto [first_seed, after_seeds] = RowsWithAny(seeds);
  if (after_seeds == 0) return;
  const int begin = std::max(first_seed - kReach, 0), end = std::min(after_seeds + kReach, seeds.rows);
  const cv::Mat1b steps = StepsFrom(seeds, flat, begin, end);
  cv::Mat1b to_texture;
  cv::distanceTransform(flat, to_texture, cv::DIST_L1, 3, CV_8U);
  const auto forget = [&](int v, int u) { disparity(v, u) = sigma(v, u) = kUnknownDisparity; };
  const auto for_each_pixel = [&](int y, int x, const auto& use) {
    for (int v = 2 * y; v < std::min(2 * y + 2, image.rows); ++v)
      for (int u = 2 * x; u < std::min(2 * x + 2, image.cols); ++u) use(v, u);
  };
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < steps.cols; ++x) {
      // A wall that goes on flat behind what hides a part of it is no fringe.
      if (steps(y, x) == kNotReached || steps(y, x) + to_texture(y, x) > kReach) continue;
      for_each_pixel(y, x, forget);
      // Beside it the image is no longer flat, since an edge runs there, on whose near side are some pixels
      // more.
      const int grey = half_image(y, x);
      for (const auto& [dy, dx] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
        const int j = y + dy, i = x + dx;
        if (j < 0 || i < 0 || j >= steps.rows || i >= steps.cols || flat(j, i) != 0) continue;
        for_each_pixel(j, i, [&](int v, int u) {
          if (std::abs(image(v, u) - grey) <= kSameGrey) forget(v, u);
        });
      }
    }
  }
}

}  // namespace terrace
