// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/flat_fringes.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "stereo/half_resolution.h"
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
cv::Mat1b UnknownPixels(const cv::Mat1f& disparity) {
  cv::Mat1b known, known_of_four, unknown;
  cv::compare(disparity, disparity, known, cv::CMP_EQ);  // what is not a number does not equal itself
  HalveImage(known, known_of_four);
  cv::compare(known_of_four, 0.0, unknown, cv::CMP_EQ);
  return unknown;
}

/// The rectangle and so many pixels on every side, as far as the image goes.
cv::Rect Widened(const cv::Rect& rectangle, int margin, const cv::Size& size) {
  const cv::Rect wide(rectangle.x - margin, rectangle.y - margin, rectangle.width + 2 * margin,
                      rectangle.height + 2 * margin);
  return wide & cv::Rect({0, 0}, size);
}

/// Steps, at most kReach, from a seed to each flat pixel, over flat pixels only.
cv::Mat1b StepsFrom(const cv::Mat1b& seeds, const cv::Mat1b& flat) {
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
  for (int y = 0; y < steps.rows; ++y) {
    std::uint8_t* const row = steps[y];
    const std::uint8_t* const is_flat = flat[y];
    for (int x = 0; x < steps.cols; ++x)
      if (is_flat[x] != 0) step_from(row + x - 1, row + x - width, row + x);
  }
  for (int y = steps.rows - 1; y >= 0; --y) {
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
  cv::Mat1b seeds = UnknownPixels(disparity) & flat;
  // Not from the holes that every flat surface has.
  cv::erode(seeds, seeds, cv::Mat1b::ones(7, 7));
  const cv::Rect with_seeds = cv::boundingRect(seeds);
  if (with_seeds.empty()) return;
  const cv::Rect reached = Widened(with_seeds, kReach, seeds.size());
  const cv::Mat1b steps = StepsFrom(seeds(reached), flat(reached));
  // Texture further away than kReach does not count.
  const cv::Rect around = Widened(reached, kReach, seeds.size());
  cv::Mat1b to_texture;
  cv::distanceTransform(flat(around), to_texture, cv::DIST_L1, 3, CV_8U);
  to_texture = to_texture(reached - around.tl());
  const auto forget = [&](int v, int u) { disparity(v, u) = sigma(v, u) = kUnknownDisparity; };
  const auto for_each_pixel = [&](int y, int x, const auto& use) {
    for (int v = 2 * y; v < std::min(2 * y + 2, image.rows); ++v)
      for (int u = 2 * x; u < std::min(2 * x + 2, image.cols); ++u) use(v, u);
  };
  for (int y = reached.y; y < reached.br().y; ++y) {
    for (int x = reached.x; x < reached.br().x; ++x) {
      const int num_steps = steps(y - reached.y, x - reached.x);
      // A wall that goes on flat behind what hides a part of it is no fringe.
      if (num_steps == kNotReached || num_steps + to_texture(y - reached.y, x - reached.x) > kReach) continue;
      for_each_pixel(y, x, forget);
      // Beside it the image is no longer flat, since an edge runs there, on whose near side are some pixels
      // more.
      const int grey = half_image(y, x);
      for (const auto& [dy, dx] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
        const int j = y + dy, i = x + dx;
        if (j < 0 || i < 0 || j >= flat.rows || i >= flat.cols || flat(j, i) != 0) continue;
        for_each_pixel(j, i, [&](int v, int u) {
          if (std::abs(image(v, u) - grey) <= kSameGrey) forget(v, u);
        });
      }
    }
  }
}

}  // namespace terrace
