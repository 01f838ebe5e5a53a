// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/steep_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>

#include "core/parallel_for.h"
#include "stereo/disparity_units.h"
#include "stereo/unknown_disparity.h"

namespace terrace {
namespace {

constexpr int kBlockPx = 16;
constexpr int kSampleStepPx = 2;
constexpr float kSamePart_px = 2.0f;  ///< from a block's mean: what is further off does not count
/// [px per row]: a lesser slope leaves a window of 5x5 pixels within the pixel that parts surfaces.
constexpr float kMinSlope = 0.38f;
constexpr int kMaxSlopeUnits = 8 * UnitImage::kUnitsPerPx;
constexpr int kReach = 3;  ///< rows on either side that a line is laid through
constexpr int kRows = 2 * kReach + 1;
constexpr float kSumOfSquares = 28.0f;  ///< of -kReach ... kReach
/// Of the squares that two levels with a jump between them leave, those that a line leaves are less.
constexpr float kMaxShareOfJump = 0.2f;

/// The mean of those pixels that are near the mean; NaN where most of them are not.
float MeanOfBlock(const float* disparity, int count) {
  const auto mean_of = [&](const auto& counts) {
    float sum = 0.0f;
    int num = 0, num_samples = 0;
    for (int i = 0; i < count; i += kSampleStepPx, ++num_samples)
      if (counts(disparity[i])) sum += disparity[i], ++num;
    return 2 * num < num_samples ? kUnknownDisparity : sum / static_cast<float>(num);
  };
  const float mean = mean_of([](float d) { return !std::isnan(d); });
  if (std::isnan(mean)) return mean;
  return mean_of([mean](float d) { return std::abs(d - mean) <= kSamePart_px; });
}

/// Squares that remain when both sides of a jump, wherever it is, have their mean taken off.
float MisfitOfJump(const float* means) {
  float total = 0.0f, squares = 0.0f;
  for (int k = 1; k < kRows; ++k) {
    const float d = means[k] - means[0];
    total += d, squares += d * d;
  }
  float least = std::numeric_limits<float>::infinity(), before = 0.0f;
  for (int k = 1; k < kRows; ++k) {
    before += means[k - 1] - means[0];
    const float behind = total - before;
    const float explained =
        before * before / static_cast<float>(k) + behind * behind / static_cast<float>(kRows - k);
    least = std::min(least, squares - explained);
  }
  return least;
}

/// Sets to 0 what a block has alone: noise. True: something is left.
bool KeepWhatNeighboursShare(int num_blocks, std::int16_t* slopes) {
  const auto alike = [](int a, int b) {
    return a != 0 && b != 0 && 4 * std::abs(a - b) <= std::max(std::abs(a), std::abs(b));
  };
  bool any = false, like_before = false;
  for (int b = 0; b < num_blocks; ++b) {
    const bool like_next = b + 1 < num_blocks && alike(slopes[b], slopes[b + 1]);
    if (!like_before && !like_next) slopes[b] = 0;
    any |= slopes[b] != 0;
    like_before = like_next;
  }
  return any;
}

}  // namespace

void SteepSurfaces::Measure(const cv::Mat1f& disparity_px) {
  rows_ = disparity_px.rows;
  blocks_ = (disparity_px.cols + kBlockPx - 1) / kBlockPx;
  const std::size_t size = static_cast<std::size_t>(rows_) * blocks_;
  means_.resize(size);
  lines_.assign(size, {});
  slopes_.assign(size, 0);
  any_.resize(rows_);
  ParallelFor(rows_, [&](int v) {
    for (int b = 0; b < blocks_; ++b)
      means_[static_cast<std::size_t>(b) * rows_ + v] =
          MeanOfBlock(disparity_px[v] + b * kBlockPx, std::min(kBlockPx, disparity_px.cols - b * kBlockPx));
  });
  ParallelFor(blocks_, [&](int b) { MeasureColumn(b); });
  for (int v = 0; v < rows_; ++v)
    any_[v] = KeepWhatNeighboursShare(blocks_, slopes_.data() + static_cast<std::size_t>(v) * blocks_);
}

void SteepSurfaces::MeasureColumn(int block) {
  const float* means = means_.data() + static_cast<std::size_t>(block) * rows_;
  Line* lines = lines_.data() + static_cast<std::size_t>(block) * rows_;
  bool any = false;
  for (int v = kReach; v + kReach < rows_; ++v) {
    // Quickly past what is level. Comparisons with NaN are false.
    if (!(std::abs(means[v + kReach] - means[v - kReach]) >= kMinSlope * kReach)) continue;
    float sum = 0.0f, product = 0.0f, misfit = 0.0f;
    for (int k = -kReach; k <= kReach; ++k)
      sum += means[v + k], product += static_cast<float>(k) * means[v + k];
    const float mean = sum / kRows, slope = product / kSumOfSquares;
    for (int k = -kReach; k <= kReach; ++k) {
      const float error = means[v + k] - mean - static_cast<float>(k) * slope;
      misfit += error * error;
    }
    if (std::abs(slope) >= kMinSlope && misfit < kMaxShareOfJump * MisfitOfJump(means + v - kReach)) {
      lines[v] = {slope, misfit};
      any = true;
    }
  }
  // A row belongs to the line that fits best of those in whose middle or at whose end it lies: beside an edge
  // that is one that does not cross it.
  for (int v = 0; any && v < rows_; ++v) {
    Line best{0.0f, std::numeric_limits<float>::infinity()};
    for (const int middle : {v, v - kReach, v + kReach})
      if (middle >= 0 && middle < rows_ && lines[middle].slope != 0.0f && lines[middle].misfit < best.misfit)
        best = lines[middle];
    const int units = static_cast<int>(std::lround(best.slope * UnitImage::kUnitsPerPx));
    slopes_[static_cast<std::size_t>(v) * blocks_ + block] =
        static_cast<std::int16_t>(std::clamp(units, -kMaxSlopeUnits, kMaxSlopeUnits));
  }
}

bool SteepSurfaces::SlopesOfRow(int v, int scale, int width, std::int16_t* slopes) const {
  if (rows_ == 0) return false;
  v = std::min(v / scale, rows_ - 1);
  if (!any_[v]) return false;
  const std::int16_t* of_blocks = slopes_.data() + static_cast<std::size_t>(v) * blocks_;
  const int end = (width + 63) / 64 * 64, block_px = kBlockPx * scale;
  for (int u = 0, b = 0; u < end; u += block_px, ++b)
    std::fill_n(slopes + u, std::min(block_px, end - u), of_blocks[std::min(b, blocks_ - 1)]);
  return true;
}

}  // namespace terrace
