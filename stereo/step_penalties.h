// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "stereo/aligned_array.h"

namespace terrace {

/// Penalties of the semi-global energy (Hirschmueller 2008), in bits of the census.
struct PathPenalties {
  int p1 = 6;       ///< for a change of disparity by one
  int p2_max = 40;  ///< for any other change, where the image is flat
  int p2_min = 16;  ///< the same across an edge of the image
};

/// The penalty P2 of stepping between neighbours: p2_max less the difference of their brightness.
class StepPenalties {
 public:
  /// @param diagonals  whether diagonal steps are asked for, too
  void Compute(const cv::Mat1b& image, const PathPenalties& penalties, bool diagonals = false);
  /// Of the step from (u - 1, v) to (u, v).
  const std::uint8_t* FromLeft(int v) const { return Row(v, 0); }
  /// Of the step from (u + du, v - 1) to (u, v); du = -1, 0 or 1.
  const std::uint8_t* FromAbove(int v, int du) const { return Row(v, du == 0 ? 1 : du < 0 ? 2 : 3); }

 private:
  const std::uint8_t* Row(int v, int kind) const {
    return bytes_.data() + (static_cast<std::size_t>(v) * num_kinds_ + kind) * stride_;
  }

  int num_kinds_ = 0;
  std::size_t stride_ = 0;
  AlignedArray<std::uint8_t> bytes_;
};

}  // namespace terrace
