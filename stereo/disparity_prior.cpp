// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/disparity_prior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace terrace {
namespace {

/// How far from where it is predicted a point may appear in the image.
constexpr double kReachPx = 8.0;
constexpr int kSampleStepPx = 8;
/// Of the samples that a tile could have, those it must have: where the earlier frame knew little, or what it
/// knew has moved apart, more may appear.
constexpr double kMinSampleShare = 0.75;
constexpr double kMinDepth_m = 0.01;

/// What falls into a tile, by disparity. Single samples are not believed.
class TileSamples {
 public:
  void Add(float d, bool own) {
    const int bin = std::clamp(static_cast<int>(d) / kBinPx, 0, kNumBins - 1);
    ++counts_[bin];
    num_own_ += own;
  }
  int num_own() const { return num_own_; }  ///< not from the reach of other tiles' samples
  DisparityPrior::Range Range() const {
    DisparityPrior::Range range;
    for (int bin = 0; bin < kNumBins; ++bin) {
      if (counts_[bin] < kMinCount) continue;
      if (!range.known()) range.low_px = static_cast<float>(bin * kBinPx);
      range.high_px = static_cast<float>((bin + 1) * kBinPx);
    }
    return range;
  }

 private:
  static constexpr int kBinPx = 4, kNumBins = 64;
  static constexpr int kMinCount = 2;
  std::array<std::uint16_t, kNumBins> counts_{};
  int num_own_ = 0;
};

}  // namespace

DisparityPrior::DisparityPrior(int width, int height)
    : rows((height + kTilePx - 1) / kTilePx),
      columns((width + kTilePx - 1) / kTilePx),
      tiles(static_cast<std::size_t>(rows) * columns) {}

DisparityPrior PredictDisparities(const DisparityImage& earlier, const StereoCamera& camera,
                                  const Eigen::Isometry3d& T_now_earlier) {
  constexpr int kTilePx = DisparityPrior::kTilePx;
  const cv::Mat1f& disparity = earlier.disparity_px;
  DisparityPrior prior(disparity.cols, disparity.rows);
  std::vector<TileSamples> samples(prior.tiles.size());
  const auto tile_of = [](double pixel) { return static_cast<int>(std::floor(pixel / kTilePx)); };
  const auto add = [&](const Eigen::Vector2d& at, float d) {
    const int own_row = tile_of(at.y()), own_column = tile_of(at.x());
    const int top = std::max(tile_of(at.y() - kReachPx), 0), left = std::max(tile_of(at.x() - kReachPx), 0);
    const int bottom = std::min(tile_of(at.y() + kReachPx), prior.rows - 1);
    const int right = std::min(tile_of(at.x() + kReachPx), prior.columns - 1);
    for (int row = top; row <= bottom; ++row)
      for (int column = left; column <= right; ++column)
        samples[static_cast<std::size_t>(row) * prior.columns + column].Add(
            d, row == own_row && column == own_column);
  };
  for (int v = kSampleStepPx / 2; v < disparity.rows; v += kSampleStepPx)
    for (int u = kSampleStepPx / 2; u < disparity.cols; u += kSampleStepPx) {
      const float d = disparity(v, u);
      if (std::isnan(d) || !(d > 0.0f)) continue;
      const Eigen::Vector3d p_now = T_now_earlier * camera.Triangulate(u, v, d);
      if (p_now.z() < kMinDepth_m) continue;
      add(camera.Project(p_now), static_cast<float>(camera.Disparity(p_now.z())));
    }
  for (int row = 0; row < prior.rows; ++row)
    for (int column = 0; column < prior.columns; ++column) {
      const int width = std::min(kTilePx, disparity.cols - column * kTilePx);
      const int height = std::min(kTilePx, disparity.rows - row * kTilePx);
      const double possible = static_cast<double>(width * height) / (kSampleStepPx * kSampleStepPx);
      const TileSamples& tile = samples[static_cast<std::size_t>(row) * prior.columns + column];
      if (tile.num_own() >= kMinSampleShare * possible) prior.At(row, column) = tile.Range();
    }
  return prior;
}

}  // namespace terrace
