// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/landmark_sightings.h"
#include "odometry/feature_finder.h"
#include "odometry/image_pyramid.h"
#include "odometry/pose_finder.h"
#include "odometry/window.h"

namespace terrace {

/// Makes keyframes and landmarks, and counts what becomes of these.
class KeyframeMaker {
 public:
  KeyframeMaker(const StereoCamera& camera, const FeatureGrid& grid, int max_disparity_px)
      : grid_(grid), finder_(camera, grid, max_disparity_px) {}

  /// Features of a frame that has nothing to do with the window.
  std::vector<Landmark> Look(const ImagePyramid& left, const ImagePyramid& right, double vertical_px) const;

  /// What has been made.
  struct Made {
    bool rests = false;          ///< the camera had hardly moved since the keyframe before
    double covered_cells = 1.0;  ///< with a landmark now
  };
  /// Puts a keyframe into the window, with new landmarks where the found ones leave cells empty.
  /// @param keyframe  all but its id and image
  Made Make(Keyframe keyframe, const ImagePyramid& left, const ImagePyramid& right, double vertical_px,
            const PoseFinder::Found& found, Window& window, FrameSightings& sightings);

 private:
  FeatureGrid grid_;
  FeatureFinder finder_;
  KeyframeId next_keyframe_id_ = 0;
  std::int64_t next_landmark_id_ = 0;
};

/// Counts for every landmark that was looked for whether it agreed with the pose.
void CountFates(const PoseFinder::Found& found, Window& window);
/// The same for people to see.
void NoteSightings(const PoseFinder::Found& found, const Window& window, FrameSightings& sightings);

}  // namespace terrace
