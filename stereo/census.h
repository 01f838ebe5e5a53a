// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "stereo/aligned_array.h"

namespace terrace {

/// One bit of a census word: is the pixel at the first offset brighter than the one at the second?
struct CensusPair {
  int du1, dv1, du2, dv2;
};

/// 24 bits: every pixel of the 5x5 window against its centre. Keeps fine detail.
std::vector<CensusPair> Census5x5();
/// 31 bits: every pixel of the 9x7 window against the one mirrored at the centre. Best in noise and darkness.
std::vector<CensusPair> Census9x7();

/// 32 bits: every second pixel of the 7x7 window against its centre, and eight mirrored pairs between them.
/// As sharp at edges as the 5x5 one, and steadier.
std::vector<CensusPair> CensusMixed();

/// The census words of an image as planes of bytes: byte p of a pixel's word is in plane p, so that the words
/// of consecutive pixels are consecutive in memory. Rows are continued by kLeftMargin and kRightMargin pixels
/// whose content means nothing.
class CensusImage {
 public:
  static constexpr int kLeftMargin = 320;
  static constexpr int kRightMargin = 128;
  static constexpr int kNumPlanes = 4;
  static constexpr int kBorder = 4;  ///< greatest offset of a pair

  /// Offsets reach at most kBorder pixels; the image's edge pixels are repeated outside of it.
  void Compute(const cv::Mat1b& image, const std::vector<CensusPair>& pairs);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Pixel (0, v) of a plane.
  const std::uint8_t* Row(int v, int plane) const {
    return bytes_.data() + (static_cast<std::size_t>(v) * kNumPlanes + plane) * stride_ + kLeftMargin;
  }

 private:
  int width_ = 0, height_ = 0;
  std::size_t stride_ = 0;
  AlignedArray<std::uint8_t> bytes_;
  cv::Mat1b padded_;
};

}  // namespace terrace
