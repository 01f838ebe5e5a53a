// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <tbb/enumerable_thread_specific.h>

#include "core/parallel_for.h"
#include "stereo/aligned_array.h"
#include "stereo/refinement_rows.h"

namespace terrace {
namespace {

constexpr int kRowsPerStrip = 60;
constexpr int kWholeVectors = 64;      // floats: a multiple of every target's vectors
constexpr int kRing = 2 * kReach + 2;  // rows needed at once: those of a window, and the one that leaves it

/// How much brighter the left image is, from every eighth row's pixels with a disparity: ratio of their
/// spreads.
float MeasureGain(const cv::Mat1b& left, const cv::Mat1b& right, const UnitImage& units) {
  std::int64_t n = 0, l1 = 0, r1 = 0, l2 = 0, r2 = 0;
  for (int v = 4; v < left.rows; v += 8) {
    const std::int16_t* disparity = units.Row(v);
    for (int u = 0; u < left.cols; u += 2) {
      const int x = (u * kUnitsPerPx - disparity[u] + kUnitsPerPx / 2) / kUnitsPerPx;
      if (disparity[u] == 0 || x < 0) continue;
      const std::int64_t l = left(v, u), r = right(v, std::min(x, right.cols - 1));
      if (l == 0 || l == 255 || r == 0 || r == 255) continue;
      ++n, l1 += l, r1 += r, l2 += l * l, r2 += r * r;
    }
  }
  if (n < 100) return 1.0f;
  const double var_l =
      static_cast<double>(l2) - static_cast<double>(l1) * static_cast<double>(l1) / static_cast<double>(n);
  const double var_r =
      static_cast<double>(r2) - static_cast<double>(r1) * static_cast<double>(r1) / static_cast<double>(n);
  if (var_l <= 0 || var_r <= 0) return 1.0f;
  return static_cast<float>(std::clamp(std::sqrt(var_l / var_r), 0.5, 2.0));
}

std::size_t Padded(int width) { return static_cast<std::size_t>((width + 63) / 64 * 64); }

}  // namespace

/// What one thread holds while it works on a strip: the residuals of the last kRing rows, sums of their
/// columns, and the results of one row.
class Refiner::StripRows {
 public:
  void Prepare(int width) {
    const std::size_t stride = Padded(width) + 2 * kRowMargin;
    constexpr std::size_t kNumResiduals = 6;
    constexpr std::size_t kNumShorts = 3 + kNumResiduals * kRing + 3;
    if (width != width_) {
      width_ = width;
      std::int16_t* next = shorts_.Reserve(kNumShorts * stride);
      const auto take_shorts = [&] { return std::exchange(next, next + stride) + kRowMargin; };
      float* next_float = floats_.Reserve(5 * stride);
      const auto take_floats = [&] { return std::exchange(next_float, next_float + stride) + kRowMargin; };
      columns = {take_shorts(), take_shorts(), take_shorts()};
      for (ResidualRow& row : ring_)
        row = {take_shorts(), take_shorts(), take_shorts(), take_shorts(), take_shorts(), take_shorts()};
      sums = {take_shorts(), take_shorts(), take_shorts(), take_floats(), take_floats(), take_floats()};
      disparity = take_floats();
      sigma = take_floats();
    }
    // No row has entered the sums yet.
    std::fill_n(shorts_.data(), kNumShorts * stride, std::int16_t{0});
    std::fill_n(floats_.data(), 5 * stride, 0.0f);
    for (ResidualRow& row : ring_) row.any_steep = false;
  }
  ResidualRow& At(int v) { return ring_[(v + 2 * kRing) % kRing]; }
  /// Rows v - kReach to v + kReach.
  std::array<ResidualRow, 2 * kReach + 1> Around(int v) {
    return {At(v - 2), At(v - 1), At(v), At(v + 1), At(v + 2)};
  }
  ColumnDisparities columns;
  ColumnSums sums;
  float* disparity = nullptr;
  float* sigma = nullptr;

 private:
  int width_ = 0;
  std::array<ResidualRow, kRing> ring_;
  AlignedArray<std::int16_t> shorts_;
  AlignedArray<float> floats_;
};

class Refiner::Scratch {
 public:
  tbb::enumerable_thread_specific<StripRows> rows;
  cv::Mat1b padded_left, padded_right;
  UnitImage given, refined;
  std::vector<std::int16_t> unknown;  ///< a row outside the image
};

Refiner::Refiner(const RefinementSettings& settings)
    : settings_(settings), scratch_(std::make_unique<Scratch>()) {}
Refiner::~Refiner() = default;

void Refiner::Refine(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity, cv::Mat1f* sigma,
                     const Steepness& steepness) {
  scratch_->given.Set(disparity);
  Refine(left, right, scratch_->given, disparity, sigma, steepness);
}

void Refiner::Refine(const cv::Mat1b& left, const cv::Mat1b& right, UnitImage& given, cv::Mat1f& disparity,
                     cv::Mat1f* sigma, const Steepness& steepness) {
  const int height = left.rows;
  const int num_strips = (height + kRowsPerStrip - 1) / kRowsPerStrip;
  Scratch& scratch = *scratch_;
  cv::copyMakeBorder(left, scratch.padded_left, 0, 0, kImageBorder, kImageBorder, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(right, scratch.padded_right, 0, 0, kImageBorder, kImageBorder, cv::BORDER_REPLICATE);
  disparity.create(left.size());
  if (sigma) sigma->create(left.size());
  scratch.refined.Create(left.size());
  scratch.unknown.assign(Padded(left.cols) + 2 * kRowMargin, 0);
  const float gain = MeasureGain(left, right, given);
  const RefineLimits limits = {static_cast<std::int16_t>(std::lround(settings_.max_jump_px * kUnitsPerPx)),
                               static_cast<std::int16_t>(std::lround(gain * 8192)), settings_.max_step_px,
                               settings_.given_sigma_px};
  for (int iteration = 1; iteration <= settings_.iterations; ++iteration) {
    const bool last = iteration == settings_.iterations;
    ParallelFor(num_strips, [&](int strip) {
      const int top = strip * kRowsPerStrip;
      RefineStrip(top, std::min(top + kRowsPerStrip, height), limits, given, steepness,
                  last ? &disparity : nullptr, last ? sigma : nullptr);
    });
    if (!last) std::swap(given, scratch.refined);
  }
}

/// Three steps, each a few rows behind the one before.
void Refiner::RefineStrip(int top, int bottom, const RefineLimits& limits, const UnitImage& given,
                          const Steepness& steepness, cv::Mat1f* disparity, cv::Mat1f* sigma) {
  const int width = scratch_->padded_left.cols - 2 * kImageBorder, height = scratch_->padded_left.rows;
  StripRows& rows = scratch_->rows.local();
  rows.Prepare(width);
  const auto given_row = [&](int v) {
    return v >= 0 && v < height ? given.Row(v) : scratch_->unknown.data() + kRowMargin;
  };
  for (int v = top - kReach; v < bottom + kReach; ++v) {
    const std::int16_t* around[] = {given_row(v - 2), given_row(v - 1), given_row(v), given_row(v + 1),
                                    given_row(v + 2)};
    const int v_image = std::clamp(v, 0, height - 1);
    ResidualRow& row = rows.At(v);
    row.any_steep =
        steepness.surfaces && steepness.surfaces->SlopesOfRow(v_image, steepness.scale, width, row.slope);
    DisparitiesOfColumns(around, row, width, rows.columns);
    ResidualsOfRow(&scratch_->padded_left(v_image, kImageBorder),
                   &scratch_->padded_right(v_image, kImageBorder), around, rows.columns, width, limits, row);
    MoveColumnSums(row, rows.At(v - kRing + 1), width, rows.sums);

    const int v_refined = v - kReach;
    if (v_refined < top) continue;
    // Whole vectors are written to the results at once, others would reach into the next row.
    const bool in_place = width % kWholeVectors == 0;
    float* const refined = disparity && in_place ? (*disparity)[v_refined] : rows.disparity;
    float* const refined_sigma = !sigma ? nullptr : in_place ? (*sigma)[v_refined] : rows.sigma;
    RefineRow(rows.Around(v_refined).data(), rows.sums, width, limits, refined, refined_sigma);
    if (!disparity) ToUnits(refined, width, scratch_->refined.Row(v_refined));
    if (in_place) continue;
    if (disparity) std::memcpy((*disparity)[v_refined], refined, sizeof(float) * width);
    if (sigma) std::memcpy((*sigma)[v_refined], refined_sigma, sizeof(float) * width);
  }
}

}  // namespace terrace
