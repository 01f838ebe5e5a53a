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
  /// Below this the smaller eigenvalue of the gradient matrix, per pixel, tells noise from noise [grey^2].
  static constexpr float kMinTexture = 0.1f;
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

/// Has what ExtractTemplate() will read around `centre` fetched from memory while other work goes on.
/// @param centre  may lie outside the image
void PrefetchTemplate(const cv::Mat1b& image, const Eigen::Vector2f& centre);

/// Normalised correlation of a template with the image patch whose first sample is pixel (u, v); -1 outside.
float Correlation(const cv::Mat1b& image, const PatchTemplate& patch, int u, int v);

}  // namespace terrace
