// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "odometry/image_pyramid.h"
#include "odometry/window.h"

namespace terrace {

/// A chequerboard of cells over an image, so that features are spread and not heaped.
struct FeatureGrid {
  int cell_px = 32;
  int columns = 0;
  int rows = 0;

  /// About num_cells cells over an image of this size.
  static FeatureGrid For(int width, int height, int num_cells);
  int num_cells() const { return columns * rows; }
  int CellOf(double u, double v) const;
};

/// Finds new corners and their depth by stereo.
class FeatureFinder {
 public:
  FeatureFinder(const StereoCamera& camera, const FeatureGrid& grid, int max_disparity_px);

  /// One new landmark for each cell that is not occupied, where there is a corner whose disparity is certain.
  /// Host and ids are left to the caller.
  /// @param vertical_px  how much lower the right image is known to be
  std::vector<Landmark> Find(const ImagePyramid& left, const ImagePyramid& right,
                             const std::vector<bool>& occupied, double vertical_px) const;

 private:
  std::vector<Eigen::Vector2i> FindCorners(const ImagePyramid& left, const std::vector<bool>& occupied) const;

  StereoCamera camera_;
  FeatureGrid grid_;
  int max_disparity_px_;
};

}  // namespace terrace
