// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/terrain_map.h"

namespace terrace {

/// How space comes onto an image: x right, y down, z away from the eye, as in a camera.
struct Projection {
  Eigen::Isometry3d T_view_world = Eigen::Isometry3d::Identity();
  bool perspective = false;
  double fx = 1.0;  ///< px; parallel projection: px/m
  double fy = 1.0;
  double cx = 0.0;
  double cy = 0.0;

  static Projection OfCamera(const StereoCamera& camera, const Eigen::Isometry3d& T_world_left);
  /// Parallel projection along `forward_world`, `up_world` upwards in the image.
  static Projection Along(const Eigen::Vector3d& forward_world, const Eigen::Vector3d& up_world);

  /// Pixel of a point; in perspective the point must lie in front of the eye.
  Eigen::Vector2d Pixel(const Eigen::Vector3d& p_world) const;
  /// True where Pixel may be asked.
  bool InFront(const Eigen::Vector3d& p_world) const;
};

/// Which region is seen at every pixel, hidden surfaces left out. Regions show only the side that was seen.
class SurfaceRaster {
 public:
  SurfaceRaster(int width, int height, const Projection& projection);

  /// @param index  what region_at gives where this region is seen
  void Draw(const TerrainRegion& region, int index);

  /// -1: none.
  int region_at(int u, int v) const { return index_[static_cast<std::size_t>(v) * width_ + u]; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_;
  int height_;
  Projection projection_;
  std::vector<float> depth_;
  std::vector<int> index_;
};

}  // namespace terrace
