// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace terrace {

/// A small square of texture that is looked for in other images, with what a least-squares fit needs.
struct PatchTemplate {
  static constexpr int kSize = 12;
  static constexpr int kArea = kSize * kSize;
  /// Offset of sample i from the centre.
  static constexpr float Offset(int i) { return static_cast<float>(i) - 0.5f * (kSize - 1); }

  alignas(16) float value[kArea];  ///< mean removed
  alignas(16) float gradient_u[kArea];
  alignas(16) float gradient_v[kArea];
  /// Where the camera's range ends: kTooBright, kTooDark or both. Written only when `clipped`.
  std::uint8_t clip[kArea];
  bool clipped = false;
  /// Inverse normal matrix of the basis (gradient_u, gradient_v, value, 1).
  Eigen::Matrix4f inverse_normal;
};

/// Samples a template at `centre` of the image, warped: sample o is read at centre + A * o.
/// @return false when it leaves the image or shows no corner.
bool ExtractTemplate(const cv::Mat1b& image, const Eigen::Vector2f& centre,
                     const Eigen::Matrix2f& A_image_template, PatchTemplate& patch);

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

/// Normalised correlation of a template with the image patch whose first sample is pixel (u, v); -1 outside.
float Correlation(const cv::Mat1b& image, const PatchTemplate& patch, int u, int v);

/// A feature of the left image in the right one, with the slant of the surface it lies on.
struct StereoAlignment {
  float disparity_px = 0.0f;
  float gradient_u = 0.0f;   ///< change of disparity per pixel to the right in the left image
  float gradient_v = 0.0f;   ///< and per pixel down
  float vertical_px = 0.0f;  ///< v in the right image less v in the left one
  float agreement = 0.0f;
  float disparity_sigma_px = 1.0f;
  float gradient_sigma = 1.0f;
};

/// Finds disparity and slant together, from a disparity that is right to about two pixels.
/// @param vertical_px  how much lower the right image is known to be
bool AlignStereo(const cv::Mat1b& left, const cv::Mat1b& right, const Eigen::Vector2f& position_left,
                 float vertical_px, StereoAlignment& result);

}  // namespace terrace
