// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/depth_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "core/parallel_for.h"

namespace terrace {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr int kBorder = 4;
constexpr int kFractions = 16;  // of a pixel, to which the right image is interpolated
constexpr int kWindowPixels = 15;
constexpr int kNoMatch = 1 << 20;
constexpr int kNotYet = -1;
constexpr float kClearlyBetter = 0.8f;  // of its own difference, to leave one's disparity for another

/// Sum of absolute differences between windows of 5x3 pixels that end or begin at the pixel, whichever agree
/// better: one of them lies on the pixel's own side of a depth edge.
class WindowDifference {
 public:
  WindowDifference(const cv::Mat1b& left, const cv::Mat1b& right) : width_(left.cols) {
    cv::copyMakeBorder(left, left_, 1, 1, kBorder, kBorder, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(right, right_, 1, 1, kBorder, kBorder + 1, cv::BORDER_REPLICATE);
  }
  int At(int u, int v, float disparity) const {
    const float x = static_cast<float>(u) - disparity;
    if (!(x >= 0.0f && x <= static_cast<float>(width_ - 1))) return kNoMatch;
    const int whole = static_cast<int>(x);
    const int f = static_cast<int>((x - static_cast<float>(whole)) * kFractions + 0.5f);
    std::array<int, 2 * kBorder + 1> column{};
    for (int row = 0; row < 3; ++row) {
      const std::uint8_t* a = left_[v + row] + u;
      const std::uint8_t* b = right_[v + row] + whole;
      for (int i = 0; i <= 2 * kBorder; ++i)
        column[i] += std::abs(kFractions * a[i] - (kFractions - f) * b[i] - f * b[i + 1]);
    }
    const int before = column[0] + column[1] + column[2] + column[3];
    const int after = column[5] + column[6] + column[7] + column[8];
    return (column[4] + std::min(before, after)) / kFractions;
  }

 private:
  int width_;
  cv::Mat1b left_, right_;
};

/// The right image with the left one's brightness: mean and spread of the pixels that correspond.
cv::Mat1b MatchBrightness(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1f& disparity) {
  double n = 0, l1 = 0, r1 = 0, l2 = 0, r2 = 0;
  for (int v = 4; v < left.rows; v += 8)
    for (int u = 0; u < left.cols; u += 2) {
      const float x = static_cast<float>(u) - disparity(v, u);
      if (!(x >= 0.0f)) continue;
      const int l = left(v, u), r = right(v, std::min(static_cast<int>(x + 0.5f), right.cols - 1));
      n += 1, l1 += l, r1 += r, l2 += l * l, r2 += r * r;
    }
  const double var_l = n * l2 - l1 * l1, var_r = n * r2 - r1 * r1;
  if (n < 100 || var_l <= 0 || var_r <= 0) return right;
  const double gain = std::clamp(std::sqrt(var_l / var_r), 0.5, 2.0), offset = (l1 - gain * r1) / n;
  cv::Mat1b table(1, 256), matched;
  for (int i = 0; i < 256; ++i) table(i) = cv::saturate_cast<std::uint8_t>(gain * i + offset);
  cv::LUT(right, table, matched);
  return matched;
}

/// Marks the pixels of a row that have an unknown disparity or one far from their own at `reach`, or are
/// unknown.
void MarkEdges(const float* row, const float* above, const float* below, int width, int reach, float min_jump,
               std::uint8_t* marks) {
  const auto smooth = [&](float other, float own) {
    return std::abs(other - own) <= min_jump;
  };  // false for NaN
  std::fill(marks, marks + width, std::uint8_t{1});
  for (int u = reach; u < width - reach; ++u) {
    const bool flat = smooth(row[u - reach], row[u]) & smooth(row[u + reach], row[u]) &
                      smooth(above[u], row[u]) & smooth(below[u], row[u]);
    marks[u] = flat ? 0 : 1;
  }
}

/// Each marked pixel's best among its own and its neighbours' disparities.
void SharpenRow(const WindowDifference& difference, const cv::Mat1f& given, int v,
                const DepthEdgeSettings& settings, float* out) {
  const int width = given.cols, reach = settings.reach_px;
  const float* row = given[v];
  const float* above = given[std::max(v - reach, 0)];
  const float* below = given[std::min(v + reach, given.rows - 1)];
  thread_local std::vector<std::uint8_t> marks;
  marks.resize(width);
  MarkEdges(row, above, below, width, reach, settings.min_jump_px, marks.data());
  for (int u = 0; u < width; ++u) {
    if (marks[u] == 0) continue;
    const float own = row[u];
    const bool known = !std::isnan(own);
    float best = own;
    int best_sum = kNotYet;
    for (const float d :
         {row[std::max(u - reach, 0)], row[std::min(u + reach, width - 1)], above[u], below[u]}) {
      // A comparison with an unknown disparity is false.
      if (!(known ? std::abs(d - own) > settings.min_jump_px : d >= 0.0f)) continue;
      if (best_sum == kNotYet)
        best_sum = static_cast<int>(known ? kClearlyBetter * static_cast<float>(difference.At(u, v, own))
                                          : settings.max_fill_difference * kWindowPixels);
      const int sum = difference.At(u, v, d);
      if (sum < best_sum) best_sum = sum, best = d;
    }
    out[u] = best;
  }
}

/// Of two pixels that claim one place of the right image the worse one loses its disparity.
void SettleClaims(const WindowDifference& difference, int v, float min_jump, int width, float* disparity) {
  thread_local std::vector<int> owner;
  owner.assign(width, -1);
  for (int u = 0; u < width; ++u) {
    const float x = static_cast<float>(u) - disparity[u];
    if (!(x >= 0.0f)) continue;
    int& other = owner[std::min(static_cast<int>(x + 0.5f), width - 1)];
    if (other >= 0 && !std::isnan(disparity[other]) && std::abs(disparity[other] - disparity[u]) > min_jump) {
      if (difference.At(u, v, disparity[u]) < difference.At(other, v, disparity[other])) {
        disparity[other] = kUnknown;
        other = u;
      } else {
        disparity[u] = kUnknown;
      }
    } else {
      other = u;
    }
  }
}

}  // namespace

void SharpenDepthEdges(const cv::Mat1b& left, const cv::Mat1b& right, const DepthEdgeSettings& settings,
                       cv::Mat1f& disparity) {
  const WindowDifference difference(left, MatchBrightness(left, right, disparity));
  cv::Mat1f given;
  for (int round = 0; round < settings.rounds; ++round) {
    disparity.copyTo(given);
    ParallelFor(left.rows, [&](int v) {
      SharpenRow(difference, given, v, settings, disparity[v]);
      SettleClaims(difference, v, settings.min_jump_px, left.cols, disparity[v]);
    });
  }
}

}  // namespace terrace
