// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/camera.h"
#include "core/place_view.h"
#include "core/pose_estimate.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Keeps views of the world that is being mapped, one for each place and direction that the camera has been
/// in, thinned so that memory stays bounded.
class ViewKeeper {
 public:
  explicit ViewKeeper(const StereoCamera& camera, std::size_t max_views = 300)
      : camera_(camera), max_views_(max_views) {}

  /// Of a frame that was mapped at this pose.
  void Add(const StereoFrame& frame, const PoseEstimate& pose);
  /// Another world, or another map, has begun.
  void Clear() { views_.clear(); }

  const std::vector<PlaceView>& views() const { return views_; }  ///< oldest first

 private:
  StereoCamera camera_;
  std::size_t max_views_;
  std::vector<PlaceView> views_;
  int frames_to_wait_ = 0;
};

/// Whether one camera sees what the other one does, from nearly the same place.
bool AreNeighbours(const Eigen::Isometry3d& T_world_left_a, const Eigen::Isometry3d& T_world_left_b);

}  // namespace terrace
