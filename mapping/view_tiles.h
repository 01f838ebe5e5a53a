// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"

namespace terrace {

/// How near the image shows something, by tiles of a few pixels.
class ViewTiles {
 public:
  /// What the image says of a place.
  enum class View {
    kNone,     ///< nothing: out of view, hidden, or unknown
    kOnto,     ///< something may be there
    kThrough,  ///< it looked through
  };

  /// Begins an image of which nothing is known.
  void Clear(const StereoCamera& camera);
  void Add(int u, int v, float disparity_px) {
    float& tile = nearest_px_[static_cast<std::size_t>(v / kTilePx) * num_x_ + u / kTilePx];
    if (disparity_px > tile) tile = disparity_px;
  }
  /// Ends the image: each tile gets the nearest of itself and its right and lower neighbours; unknown where
  /// one of them is.
  void Widen();

  /// After Widen: the least disparity of what is known; infinite when nothing is.
  float farthest_px() const { return farthest_px_; }
  /// After Widen.
  /// @param centre  of a ball, left frame [m]
  View ViewOf(const Eigen::Vector3f& centre, float radius_m, float margin_px) const;

 private:
  static constexpr int kTilePx = 4;

  StereoCamera camera_;
  int num_x_ = 0;
  int num_y_ = 0;
  float farthest_px_ = 0.0F;
  std::vector<float> nearest_px_;  // greatest disparity in each tile; 0: no point
};

}  // namespace terrace
