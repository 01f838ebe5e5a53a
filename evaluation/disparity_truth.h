// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "datasets/ground_truth.h"
#include "datasets/image_file.h"
#include "evaluation/disparity_file.h"

namespace terrace {

/// What is true of a pixel of the left image.
enum class PixelTruth : std::uint8_t {
  kNotKnown = 0,  ///< counts nowhere
  kVisible = 1,   ///< its point is seen by the right camera too
  kHidden = 2,    ///< its point is outside the right image or behind something there
};

struct DisparityTruth {
  FloatImage disparity_px;
  std::vector<PixelTruth> pixels;
};

/// Visibility by warping the truth into the right image: a point is hidden when another one that is nearer by
/// more than a pixel of disparity falls on the same right pixel.
DisparityTruth ByForwardWarping(FloatImage disparity_px);

/// Visible where left and right truth agree within a pixel, hidden where they do not or the point is outside;
/// where the right truth is unknown, so is this.
DisparityTruth ByRightTruth(FloatImage left_px, const FloatImage& right_px);

/// Middlebury v3: 255 visible, 128 hidden, anything else not known.
DisparityTruth ByMask(FloatImage disparity_px, const GrayImage& mask);

/// Truth of a single pair: with a mask by it, else with the `mask0nocc.png` beside a `disp0GT.pfm`, else with
/// the right truth `disp6.png` beside a `disp2.png`, else by forward warping.
DisparityTruth LoadPairTruth(const std::filesystem::path& truth, std::optional<double> scale,
                             const std::optional<std::filesystem::path>& mask);

/// Truth of one rendered frame.
struct RenderedTruth {
  DisparityTruth disparity;
  Gray16Image labels;  ///< polygon or mesh ids; empty when there are none
};

/// The depth image is in whole millimetres, which is coarse nearby. Where a label image names a polygon whose
/// plane agrees with the depth, the disparity is that of the plane, exactly.
RenderedTruth LoadRenderedTruth(const std::filesystem::path& depth_png,
                                const std::optional<std::filesystem::path>& labels_png,
                                const TrueScene& scene, const StereoCamera& camera,
                                const Eigen::Isometry3d& T_world_left);

/// A true plane as the left camera sees it: disparity(u, v) = a * u + b * v + c.
struct DisparityPlane {
  double a = 0.0;
  double b = 0.0;
  double c = 0.0;

  double At(double u, double v) const { return a * u + b * v + c; }
};
DisparityPlane DisparityPlaneOf(const Plane& plane_left, const StereoCamera& camera);
Plane PlaneOf(const DisparityPlane& disparity, const StereoCamera& camera);

}  // namespace terrace
