// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/field_problems.h"
#include "stereo/cloud.h"

namespace terrace {
namespace {

constexpr int kMaxStep = 16;
constexpr int kUncertainStep = 4;

/// 12 is 8 + 4: 4.
int LowestBit(int i) { return i & -i; }

}  // namespace

std::vector<std::string> CloudConfig::Problems() const {
  FieldProblems problems;
  problems.RequireAbove("max_depth_sigma_m", max_depth_sigma_m, 0.0);
  problems.RequireAtLeast("min_spacing_m", min_spacing_m, 0.0);
  return problems.Take();
}

Cloud Triangulate(const DisparityImage& disparity, const StereoCamera& camera, const CloudConfig& config,
                  const cv::Mat1b& mask) {
  const cv::Mat1f& disparities = disparity.disparity_px;
  TERRACE_CHECK(disparities.cols == camera.width && disparities.rows == camera.height, disparities.cols,
                disparities.rows, camera.width, camera.height);
  TERRACE_CHECK(mask.empty() || mask.size() == disparities.size(), mask.cols, mask.rows);

  const float fb = static_cast<float>(camera.fx * camera.baseline_m);
  const float inv_fx = static_cast<float>(1.0 / camera.fx), inv_fy = static_cast<float>(1.0 / camera.fy);
  const float cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const float max_sigma_m = static_cast<float>(config.max_depth_sigma_m);
  // Pixels lie z / fx = baseline / d apart: from this disparity times a power of two on, so many are skipped.
  const float crowded_px = static_cast<float>(camera.baseline_m / std::max(config.min_spacing_m, 1e-9));

  Cloud cloud{disparity.frame_id, disparity.t_capture, {}};
  cloud.points.reserve(disparities.total() / 4);
  for (int v = 0; v < disparities.rows; ++v) {
    const float* d_row = disparities[v];
    const float* sigma_row = disparity.sigma_px[v];
    const std::uint8_t* mask_row = mask.empty() ? nullptr : mask[v];
    const float y_over_z = (static_cast<float>(v) - cy) * inv_fy;
    // The white fields of a chessboard; coarser steps lie on them, too.
    for (int u = v & 1; u < disparities.cols; u += 2) {
      const float d = d_row[u];
      // The widest of the grids that hold the pixel; from there on that it would be too narrow, it is
      // skipped.
      const int widest = LowestBit(u | v | kMaxStep);
      const bool skipped = widest < kMaxStep && d >= crowded_px * static_cast<float>(2 * widest);
      if (skipped || !(d > 0.0f) || (mask_row && mask_row[u] == 0)) continue;
      const float z = fb / d;
      const float sigma_z = z / d * sigma_row[u];  // |dz/dd| = f b / d^2
      const bool certain = sigma_z <= max_sigma_m;
      if (!certain && (((u | v) & (kUncertainStep - 1)) != 0 || !std::isfinite(sigma_z))) continue;
      std::vector<CloudPoint>& points = certain ? cloud.points : cloud.uncertain;
      points.push_back({{(static_cast<float>(u) - cx) * inv_fx * z, y_over_z * z, z},
                        static_cast<std::uint16_t>(u),
                        static_cast<std::uint16_t>(v),
                        sigma_z});
    }
  }
  return cloud;
}

}  // namespace terrace
