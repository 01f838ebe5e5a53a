// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "mapping/leaf_address.h"
#include "mapping/mapping_config.h"
#include "stereo/cloud.h"

namespace terrace {

/// A few points of a frame and the leaves that they fall into, in columns.
struct PlacedPoints {
  static constexpr std::size_t kMost = 64;
  template <typename T>
  using Column = std::array<T, kMost>;

  LeafAddress Address(std::size_t i) const {
    LeafAddress address;
    address.packed = std::uint64_t(level_and_x[i]) << 32 | y_and_z[i];
    return address;
  }

  Column<std::uint32_t> level_and_x, y_and_z;  ///< upper and lower half of the leaf's address
  Column<float> x_m, y_m, z_m;                 ///< from the centre of the leaf, axes of the world
  Column<float> weight;                        ///< 1 / variance [1/m^2]; 0: the point lies in no leaf
  Column<float> disparity_px;
};

/// Finds the leaves into which the points of one frame fall, many at once.
class PointPlacer {
 public:
  /// @param T_world_left  at a place that the octree can count to
  PointPlacer(const StereoCamera& camera, const Eigen::Isometry3d& T_world_left, const MappingConfig& config);

  /// Points that are no numbers, not in front of the camera or too far away for the octree lie in no leaf.
  /// @param count  at most PlacedPoints::kMost
  void Place(const CloudPoint* points, std::size_t count, PlacedPoints* placed) const;

  /// What is the same for all points.
  struct Frame {
    Eigen::Matrix3f R_leaves_left;   ///< turns into the axes of the world, in finest leaves per metre
    Eigen::Vector3f in_camera_leaf;  ///< of the camera, from the corner of the leaf that it is in, in leaves
    LeafIndex camera_leaf;
    float leaf_m, sigma_factor, pose_variance_m2, fb_px_m;
    int coarsest_level;
    /// Level l is used up to this depth [m], while a leaf is wide enough in pixels; the coarsest one beyond.
    std::array<float, 8> max_z_m{};
  };

 private:
  Frame frame_;
};

}  // namespace terrace
