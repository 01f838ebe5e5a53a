// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/camera.h"
#include "odometry/landmark_tracker.h"
#include "odometry/pose_finder.h"
#include "odometry/window.h"
#include "stereo/pair_monitor.h"

namespace terrace {

/// Notices images that are torn: above some row they show this moment, below it the one before, or the other
/// way round, as a buffer does that is read while it is written. On one side the landmarks are where the pose
/// says, on the other where they were a frame ago. A pose that follows the older side is not noticed here: an
/// IMU contradicts it.
class TornImages {
 public:
  TornImages(const StereoCamera& camera, const FeatureGrid& grid) : camera_(camera), tracker_(camera, grid) {}

  /// Looks at a frame that was tracked.
  /// @param T_world_before  where the camera was in the frame before
  void See(const Window& window, const ImagePyramid& left, const ImagePyramid& right,
           const PoseFinder::Found& found, const Eigen::Isometry3d& T_world_before);

  /// This frame is torn, or enough of the last ones were.
  bool torn() const { return torn_; }

 private:
  /// Rows of one part of the image.
  struct Part {
    double first_row = 0.0, end_row = 0.0;
    bool Holds(double row) const { return row >= first_row && row < end_row; }
  };
  /// The part in which nearly nothing is where the pose says, though it is in the rest; empty: none.
  Part StrangePart(const Window& window, const PoseFinder::Found& found,
                   const Eigen::Isometry3d& T_world_before) const;
  bool ShowsTheMomentBefore(const Part& part, const Window& window, const ImagePyramid& left,
                            const ImagePyramid& right, const Eigen::Isometry3d& T_world_left,
                            const Eigen::Isometry3d& T_world_before) const;

  StereoCamera camera_;
  LandmarkTracker tracker_;
  LastingFinding lasting_;
  bool torn_ = false;
};

}  // namespace terrace
