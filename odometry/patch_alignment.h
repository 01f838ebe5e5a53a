// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "odometry/patch.h"

namespace terrace {

/// Where and how well a template was found.
struct Alignment {
  Eigen::Vector2f position = Eigen::Vector2f::Zero();  ///< px of the level searched
  float gain = 1.0f;                                   ///< contrast against the template
  float agreement = 0.0f;  ///< share of the variance that the template explains, 0..1
  Eigen::Matrix2f covariance = Eigen::Matrix2f::Identity();  ///< px^2, from residual and texture
};

/// Moves the template over the image, from `start`, until the squared difference is least; contrast and
/// brightness are free. Each iteration fits the image patch by gradient_u, gradient_v, value and 1: a linear
/// problem whose first two coefficients are the shift times the contrast. What is
/// too bright or too dark for the camera, in the template or in the image, only tells that the true grey is
/// not less or not more: it has no say where that explains the difference.
/// @return false when it leaves the image, does not settle or drifts more than max_shift_px away.
bool Align(const cv::Mat1b& image, const PatchTemplate& patch, const Eigen::Vector2f& start,
           int max_iterations, float max_shift_px, Alignment& result);

}  // namespace terrace
