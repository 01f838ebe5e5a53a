// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/place_view.h"
#include "core/pose_estimate.h"
#include "daemon/map_placing.h"
#include "odometry/place_recognition.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Finds where the camera is in a loaded map by the views that were saved with it. One frame is compared with
/// all views, a few of them a frame; what it finds is believed when all views that recognise it say the same,
/// up is up in both, and another frame says so too.
class PlaceFinder {
 public:
  explicit PlaceFinder(const StereoCamera& camera) : camera_(camera) {}

  /// Begins anew with these views, also in another world.
  void Seek(std::vector<PlaceView> views);
  const std::vector<PlaceView>& views() const { return views_; }

  /// Goes on with a frame whose pose may be believed. Where the camera is in the map, once that is known.
  std::optional<CameraInMap> Look(const StereoFrame& frame, const PoseEstimate& pose,
                                  const Gravity& gravity_world, const Gravity& gravity_map);
  /// Why it is not known, a clause; empty: there is nothing to recognise.
  const std::string& reason() const { return reason_; }

 private:
  /// A frame that is being compared, and what recognised it.
  struct Round {
    std::vector<DescribedFeature> features;
    Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
    std::size_t next_view = 0;
    std::vector<CameraInMap> found;  ///< where that frame's camera is in the map
  };

  std::optional<CameraInMap> Decide(const Round& round, const Gravity& gravity_world,
                                    const Gravity& gravity_map);

  StereoCamera camera_;
  std::vector<PlaceView> views_;
  std::optional<Round> round_;
  /// What the last round has found, and where the camera was in the world.
  std::optional<CameraInMap> last_;
  Eigen::Isometry3d last_T_world_left_ = Eigen::Isometry3d::Identity();
  std::uint32_t num_rounds_ = 0;
  std::string reason_;
};

}  // namespace terrace
