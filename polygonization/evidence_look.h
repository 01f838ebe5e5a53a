// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/geometry.h"
#include "core/time.h"
#include "polygonization/evidence_grid.h"
#include "polygonization/plane_frame.h"
#include "stereo/disparity_image.h"

namespace terrace {

/// What one frame shows, and from where.
struct FrameView {
  StereoCamera camera;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  const DisparityImage* disparity = nullptr;  ///< not owned
};

/// What a look at one plane found.
struct LookResult {
  int num_on = 0;       ///< cells where pixels lay on the plane
  int num_through = 0;  ///< cells where they saw through it
  int num_flipped = 0;  ///< cells that belong to the surface from now on, or no longer
};

/// Asks the disparity image of one frame what it shows of planes. A pixel whose disparity agrees with the
/// plane, within what its sigma and the plane's own error allow, lies on it; one that is farther away was
/// seen through the plane; one that is nearer, and one without a disparity, say nothing.
class EvidenceLook {
 public:
  explicit EvidenceLook(const FrameView& view);

  /// Adds what the frame shows of a plane to the evidence for it.
  /// @param noise_m  of single points, along the normal
  LookResult At(const Plane& plane_world, const PlaneFrame& frame, double noise_m, EvidenceGrid* grid) const;

 private:
  struct PlaneInView;
  class BlockLook;
  /// Which blocks of a plane may be in view: along each side of the image, and in depth, how far inside a
  /// block lies is linear in its number.
  struct BlocksInView {
    std::array<Eigen::Vector3f, 5> sides;  // dot with (x, y, 1) of a block: not negative where it may be seen
    bool Hold(const EvidenceGrid::BlockKey& key) const {
      const Eigen::Vector3f at(static_cast<float>(key.first), static_cast<float>(key.second), 1.0F);
      return std::all_of(sides.begin(), sides.end(),
                         [&](const Eigen::Vector3f& s) { return s.dot(at) >= 0.0F; });
    }
  };
  /// @param block_m  edge of a block
  BlocksInView BlocksOf(const PlaneFrame& frame, double block_m) const;
  /// Whether a ball may be in view.
  bool MayShow(const Eigen::Vector3d& centre_world, double radius_m) const;

  const FrameView& view_;
  Eigen::Isometry3d T_left_world_;
  std::array<Eigen::Vector3d, 4> sides_;  // inward normals of the planes through the camera and an image edge
};

}  // namespace terrace
