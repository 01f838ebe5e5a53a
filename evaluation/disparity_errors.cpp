// SPDX-License-Identifier: BSD-3-Clause
// What single pixels say: shares of bad, missing and invented values, lock and bias.
#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/file_bytes.h"
#include "evaluation/disparity_evaluation.h"

namespace terrace {
namespace {

/// D1 of the KITTI 2015 benchmark (Menze and Geiger 2015).
constexpr double kD1_px = 3.0;
constexpr double kD1Share = 0.05;
/// Errors beyond this are mismatches, which say nothing of sub-pixel interpolation.
constexpr double kSubPixel_px = 1.0;
constexpr std::int64_t kMinBinCount = 100;

}  // namespace

void DisparityErrors::Add(const FloatImage& disparity_px, const DisparityTruth& truth) {
  if (disparity_px.width != truth.disparity_px.width || disparity_px.height != truth.disparity_px.height) {
    throw FileError("the disparity image is " + std::to_string(disparity_px.width) + "x" +
                    std::to_string(disparity_px.height) + ", the truth " +
                    std::to_string(truth.disparity_px.width) + "x" +
                    std::to_string(truth.disparity_px.height));
  }
  for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
    const bool valid = !std::isnan(disparity_px.data[i]);
    if (truth.pixels[i] == PixelTruth::kHidden) {
      ++num_hidden_;
      num_invented_ += valid;
    }
    if (truth.pixels[i] != PixelTruth::kVisible) continue;
    ++num_visible_;
    if (!valid) continue;
    ++num_valid_;
    const double d = truth.disparity_px.data[i];
    const double error = disparity_px.data[i] - d;
    const double size = std::abs(error);
    for (std::size_t k = 0; k < kBad_px.size(); ++k) num_bad_[k] += size > kBad_px[k];
    num_d1_ += size > kD1_px && size > kD1Share * d;
    sum_absolute_ += size;
    sum_square_ += size * size;
    if (size > kSubPixel_px) continue;
    const int bin = std::min(static_cast<int>((d - std::floor(d)) * kNumBins), kNumBins - 1);
    ++bin_counts_[static_cast<std::size_t>(bin)];
    bin_sums_[static_cast<std::size_t>(bin)] += error;
  }
}

double DisparityErrors::Share(std::int64_t count, std::int64_t of) const {
  return of > 0 ? 100.0 * static_cast<double>(count) / static_cast<double>(of) : 0.0;
}

std::int64_t DisparityErrors::NumBad(double bad_px) const {
  const auto it = std::find(kBad_px.begin(), kBad_px.end(), bad_px);
  TERRACE_CHECK(it != kBad_px.end(), bad_px);
  return num_bad_[static_cast<std::size_t>(it - kBad_px.begin())];
}

double DisparityErrors::density_pct() const { return Share(num_valid_, num_visible_); }
double DisparityErrors::bad_valid_pct(double bad_px) const { return Share(NumBad(bad_px), num_valid_); }
double DisparityErrors::bad_all_pct(double bad_px) const {
  return Share(NumBad(bad_px) + num_visible_ - num_valid_, num_visible_);
}
double DisparityErrors::d1_valid_pct() const { return Share(num_d1_, num_valid_); }
double DisparityErrors::d1_all_pct() const {
  return Share(num_d1_ + num_visible_ - num_valid_, num_visible_);
}
double DisparityErrors::average_px() const {
  return num_valid_ > 0 ? sum_absolute_ / static_cast<double>(num_valid_) : 0.0;
}
double DisparityErrors::rms_px() const {
  return num_valid_ > 0 ? std::sqrt(sum_square_ / static_cast<double>(num_valid_)) : 0.0;
}
double DisparityErrors::invented_pct() const { return Share(num_invented_, num_hidden_); }

double DisparityErrors::lock_px() const {
  double greatest = 0.0;
  for (std::size_t k = 0; k < bin_counts_.size(); ++k) {
    if (bin_counts_[k] < kMinBinCount) continue;
    greatest = std::max(greatest, std::abs(bin_sums_[k] / static_cast<double>(bin_counts_[k])));
  }
  return greatest;
}

double DisparityErrors::bias_px() const {
  std::int64_t count = 0;
  double sum = 0.0;
  for (std::size_t k = 0; k < bin_counts_.size(); ++k) {
    count += bin_counts_[k];
    sum += bin_sums_[k];
  }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace terrace
