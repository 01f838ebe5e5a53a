// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/feature_finder.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "odometry/stereo_alignment.h"

namespace terrace {
namespace {

/// Corners are looked for on this level: it hides noise, and texture of this size is what the patches need.
constexpr int kCornerLevel = 1;
/// Around a corner, so that its patch and gradients lie in the image.
constexpr int kMarginPx = 10;
/// Of the smaller eigenvalue that cv::cornerMinEigenVal gives; just above what noise alone makes.
constexpr float kMinCornerStrength = 1e-5f;
/// Agreement of left and right patch a new landmark needs.
constexpr float kMinStereoAgreement = 0.8f;
/// What a disparity is good for at best, however strong its texture: interpolation and lens.
constexpr double kDisparityFloorPx = 0.05;

/// Normalised correlation along the row on a coarse level; the best whole disparity when it stands out.
std::optional<int> SearchRow(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int v_right,
                             int max_disparity) {
  constexpr int kRadius = 4;
  constexpr int kWidth = 2 * kRadius + 1;
  constexpr float kArea = kWidth * kWidth;
  constexpr float kMinCorrelation = 0.7f;
  /// The runner-up, apart from the winner's neighbours, must be this much worse.
  constexpr float kMinLead = 0.04f;
  if (u - kRadius < 0 || u + kRadius >= left.cols || v - kRadius < 0 || v + kRadius >= left.rows ||
      v_right - kRadius < 0 || v_right + kRadius >= right.rows)
    return std::nullopt;

  int sum_left = 0;
  int square_left = 0;
  std::uint8_t patch[kWidth][kWidth];
  for (int j = 0; j < kWidth; ++j) {
    for (int i = 0; i < kWidth; ++i) {
      const int p = left(v + j - kRadius, u + i - kRadius);
      patch[j][i] = static_cast<std::uint8_t>(p);
      sum_left += p;
      square_left += p * p;
    }
  }
  const float variance_left =
      static_cast<float>(square_left) - static_cast<float>(sum_left) * sum_left / kArea;
  max_disparity = std::min(max_disparity, u - kRadius);
  std::vector<float> score(static_cast<std::size_t>(std::max(max_disparity + 1, 0)), -1.0f);
  for (int d = 0; d <= max_disparity; ++d) {
    int sum = 0;
    int square = 0;
    int cross = 0;
    for (int j = 0; j < kWidth; ++j) {
      const std::uint8_t* row = right[v_right + j - kRadius] + (u - d - kRadius);
      for (int i = 0; i < kWidth; ++i) {
        sum += row[i];
        square += row[i] * row[i];
        cross += row[i] * patch[j][i];
      }
    }
    const float variance = static_cast<float>(square) - static_cast<float>(sum) * sum / kArea;
    const float covariance = static_cast<float>(cross) - static_cast<float>(sum) * sum_left / kArea;
    score[d] = covariance / std::sqrt(std::max(variance * variance_left, 1.0f));
  }
  if (score.empty()) return std::nullopt;
  const int best = static_cast<int>(std::max_element(score.begin(), score.end()) - score.begin());
  if (score[best] < kMinCorrelation) return std::nullopt;
  for (int d = 0; d <= max_disparity; ++d)
    if (std::abs(d - best) > 2 && score[d] > score[best] - kMinLead) return std::nullopt;
  return best;
}

}  // namespace

FeatureGrid FeatureGrid::For(int width, int height, int num_cells) {
  FeatureGrid grid;
  grid.cell_px = std::max(16, static_cast<int>(std::sqrt(static_cast<double>(width) * height / num_cells)));
  grid.columns = (width + grid.cell_px - 1) / grid.cell_px;
  grid.rows = (height + grid.cell_px - 1) / grid.cell_px;
  return grid;
}

int FeatureGrid::CellOf(double u, double v) const {
  const int column = std::clamp(static_cast<int>(u) / cell_px, 0, columns - 1);
  const int row = std::clamp(static_cast<int>(v) / cell_px, 0, rows - 1);
  return row * columns + column;
}

FeatureFinder::FeatureFinder(const StereoCamera& camera, const FeatureGrid& grid, int max_disparity_px)
    : camera_(camera), grid_(grid), max_disparity_px_(max_disparity_px) {}

std::vector<Eigen::Vector2i> FeatureFinder::FindCorners(const ImagePyramid& left,
                                                        const std::vector<bool>& occupied) const {
  cv::Mat1f strength;
  cv::cornerMinEigenVal(left[kCornerLevel], strength, 7, 3);
  constexpr int kScale = 1 << kCornerLevel;
  std::vector<Eigen::Vector2i> corners;
  for (int cell = 0; cell < grid_.num_cells(); ++cell) {
    if (occupied[static_cast<std::size_t>(cell)]) continue;
    const int u0 = std::max(cell % grid_.columns * grid_.cell_px, kMarginPx);
    const int v0 = std::max(cell / grid_.columns * grid_.cell_px, kMarginPx);
    const int u1 = std::min((cell % grid_.columns + 1) * grid_.cell_px, camera_.width - kMarginPx);
    const int v1 = std::min((cell / grid_.columns + 1) * grid_.cell_px, camera_.height - kMarginPx);
    float best = kMinCornerStrength;
    Eigen::Vector2i corner(-1, -1);
    for (int v = v0 / kScale; v < v1 / kScale; ++v) {
      for (int u = u0 / kScale; u < u1 / kScale; ++u) {
        if (strength(v, u) > best) {
          best = strength(v, u);
          corner = {u * kScale, v * kScale};
        }
      }
    }
    if (corner.x() >= 0) corners.push_back(corner);
  }
  return corners;
}

std::vector<Landmark> FeatureFinder::Find(const ImagePyramid& left, const ImagePyramid& right,
                                          const std::vector<bool>& occupied, double vertical_px) const {
  constexpr int kSearchLevel = 1;
  constexpr int kScale = 1 << kSearchLevel;
  std::vector<Landmark> found;
  for (const Eigen::Vector2i& corner : FindCorners(left, occupied)) {
    const int v_right = static_cast<int>(std::lround((corner.y() + vertical_px) / kScale));
    const auto coarse = SearchRow(left[kSearchLevel], right[kSearchLevel], corner.x() / kScale,
                                  corner.y() / kScale, v_right, max_disparity_px_ / kScale);
    if (!coarse) continue;
    StereoAlignment stereo;
    stereo.disparity_px = static_cast<float>(*coarse * kScale);
    if (!AlignStereo(left[0], right[0], corner.cast<float>(), static_cast<float>(vertical_px), stereo) ||
        stereo.agreement < kMinStereoAgreement)
      continue;

    Landmark landmark;
    landmark.pixel_host = corner.cast<double>();
    landmark.ray_host = {(corner.x() - camera_.cx) / camera_.fx, (corner.y() - camera_.cy) / camera_.fy, 1.0};
    landmark.disparity_host_px = stereo.disparity_px;
    landmark.disparity_host_sigma_px = std::hypot(stereo.disparity_sigma_px, kDisparityFloorPx);
    landmark.disparity_gradient = {stereo.gradient_u, stereo.gradient_v};
    const double fb = camera_.fx * camera_.baseline_m;
    landmark.inverse_depth = landmark.disparity_host_px / fb;
    landmark.inverse_depth_sigma = landmark.disparity_host_sigma_px / fb;
    found.push_back(std::move(landmark));
  }
  return found;
}

}  // namespace terrace
