// SPDX-License-Identifier: BSD-3-Clause
#include "terrain/resting_view.h"

#include <cmath>
#include <cstring>

namespace terrace {
namespace {

/// The camera rests as long as it is not farther than this from where the rest began: less than a cell of the
/// evidence, and about a pixel.
constexpr double kRest_m = 0.004;
constexpr double kRest_rad = 0.0025;
/// So many frames of a rest are added to the map, since their noise differs; one that repeats the frame
/// before, value by value, counts for several.
constexpr int kFramesOfRest = 40;
constexpr int kRepeatedCounts = 5;
/// The disparity is compared at every fourth pixel. A tile of 16 pixels shows something else where more than
/// half of its samples have changed. Since some flicker, so must many tiles at once, or a few in several
/// frames in a row.
constexpr int kSpacing_px = 4;
constexpr int kTileSamples = 4;
constexpr int kManyTiles = 8;
constexpr int kFewTiles = 3;
constexpr int kFramesInARow = 3;
constexpr float kSame_px = 1.0F;
constexpr float kSameShare = 0.05F;

cv::Mat1f SamplesOf(const cv::Mat1f& disparity_px) {
  cv::Mat1f samples(disparity_px.rows / kSpacing_px, disparity_px.cols / kSpacing_px);
  for (int y = 0; y < samples.rows; ++y)
    for (int x = 0; x < samples.cols; ++x) samples(y, x) = disparity_px(y * kSpacing_px, x * kSpacing_px);
  return samples;
}

bool Differ(float a_px, float b_px) {
  const bool a_known = a_px > 0.0F, b_known = b_px > 0.0F;
  if (!a_known || !b_known) return a_known != b_known;
  return std::abs(a_px - b_px) > kSame_px + kSameShare * a_px;
}

bool TileDiffers(const cv::Mat1f& before, const cv::Mat1f& now, int x0, int y0) {
  int num_changed = 0;
  for (int y = y0; y < y0 + kTileSamples; ++y)
    for (int x = x0; x < x0 + kTileSamples; ++x) num_changed += Differ(before(y, x), now(y, x));
  return 2 * num_changed > kTileSamples * kTileSamples;
}

int NumTilesThatDiffer(const cv::Mat1f& before, const cv::Mat1f& now) {
  int num_tiles = 0;
  for (int y = 0; y + kTileSamples <= now.rows; y += kTileSamples)
    for (int x = 0; x + kTileSamples <= now.cols; x += kTileSamples)
      num_tiles += TileDiffers(before, now, x, y);
  return num_tiles;
}

/// Of the same size.
bool AreTheSame(const cv::Mat1f& before, const cv::Mat1f& now) {
  return std::memcmp(before.data, now.data, now.total() * sizeof(float)) == 0;
}

bool HasMoved(const Eigen::Isometry3d& T_world_before, const Eigen::Isometry3d& T_world_now) {
  const Eigen::Isometry3d T_before_now = T_world_before.inverse() * T_world_now;
  return T_before_now.translation().norm() > kRest_m ||
         Eigen::AngleAxisd(T_before_now.linear()).angle() > kRest_rad;
}

}  // namespace

bool RestingView::ShowsNothingNew(const DisparityImage& disparity, const Eigen::Isometry3d& T_world_left) {
  const cv::Mat1f samples_px = SamplesOf(disparity.disparity_px);
  if (!reference_ || HasMoved(reference_->T_world_left, T_world_left) || ShowsSomethingElse(samples_px)) {
    reference_ = Reference{T_world_left, samples_px, samples_px};
    return false;
  }
  if (reference_->num_frames >= kFramesOfRest) return true;
  const bool repeated = AreTheSame(reference_->last_samples_px, samples_px);
  reference_->num_frames += repeated ? kRepeatedCounts : 1;
  reference_->last_samples_px = samples_px;
  return false;
}

bool RestingView::ShowsSomethingElse(const cv::Mat1f& samples_px) {
  if (reference_->samples_px.size() != samples_px.size()) return true;
  const int num_tiles = NumTilesThatDiffer(reference_->samples_px, samples_px);
  reference_->num_odd = num_tiles >= kFewTiles ? reference_->num_odd + 1 : 0;
  return num_tiles >= kManyTiles || reference_->num_odd >= kFramesInARow;
}

}  // namespace terrace
