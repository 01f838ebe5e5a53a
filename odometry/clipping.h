// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "odometry/patch.h"

namespace terrace {

// What is too bright or too dark for the camera only tells that the true grey is not less, or not more.

/// A true grey of 255 or more, of 0 or less.
constexpr std::uint8_t kTooBright = 1;
constexpr std::uint8_t kTooDark = 2;

/// kTooBright or kTooDark of a pixel, else 0.
inline std::uint8_t ClipOf(std::uint8_t grey) { return grey == 255 ? kTooBright : grey == 0 ? kTooDark : 0; }
/// The same of a bilinear sample: of all pixels that it is made of.
std::uint8_t ClipAt(const cv::Mat1b& image, float x, float y);

/// False when surely no sample within `extent` of a position is clipped.
bool MayBeClipped(const cv::Mat1b& image, const Eigen::Vector2f& position, const Eigen::Vector2f& extent);

/// Fits an image patch by a template where some samples have no say.
struct WeightedFit {
  alignas(16) float weight[PatchTemplate::kArea];  ///< 1 or 0
  float num_used = 0.0f;
  Eigen::Matrix4f normal;  ///< of the basis (gradient_u, gradient_v, value, 1)

  /// Only what is clipped in neither.
  void UseUnclipped(const PatchTemplate& patch, const std::uint8_t* clip);
  /// All but what differs from gain * template + brightness because it is clipped.
  void UseUnexplained(const PatchTemplate& patch, const std::uint8_t* clip, const float* samples, float gain,
                      float brightness);
  bool all() const { return num_used == static_cast<float>(PatchTemplate::kArea); }
  bool Solvable() const;
  Eigen::Matrix4f InverseNormal() const;
  /// Contrast and brightness of the image against the template.
  Eigen::Vector2f Exposure(const PatchTemplate& patch, const float* samples) const;

 private:
  void SumUp(const PatchTemplate& patch);
};
}  // namespace terrace
