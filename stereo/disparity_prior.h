// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "stereo/disparity_image.h"

namespace terrace {

/// Where the disparities of a frame are expected, by what is known before: from an earlier frame, or from the
/// map. It only saves work: the matcher looks elsewhere too where it does not find a match, and in turn
/// everywhere.
struct DisparityPrior {
  static constexpr int kTilePx = 32;

  struct Range {
    float low_px = 0.0f;
    float high_px = -1.0f;
    bool known() const { return low_px <= high_px; }  ///< else everything is possible
  };

  int rows = 0, columns = 0;  ///< of tiles; those at the right and lower edge may reach beyond the image
  std::vector<Range> tiles;   ///< row-major

  DisparityPrior() = default;
  /// Nothing is known.
  DisparityPrior(int width, int height);
  Range& At(int row, int column) { return tiles[static_cast<std::size_t>(row) * columns + column]; }
  const Range& At(int row, int column) const {
    return tiles[static_cast<std::size_t>(row) * columns + column];
  }
};

/// What an earlier frame says of the present one.
/// @param T_now_earlier  as well as it can be told beforehand, of the left cameras
DisparityPrior PredictDisparities(const DisparityImage& earlier, const StereoCamera& camera,
                                  const Eigen::Isometry3d& T_now_earlier);

}  // namespace terrace
