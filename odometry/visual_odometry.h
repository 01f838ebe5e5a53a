// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/landmark_sightings.h"
#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "odometry/gravity_keeper.h"
#include "odometry/odometry_config.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// What the dense comparison of the two images of a pair has found out about it, and the odometry cannot see.
struct PairTrouble {
  std::string reason;  ///< why distances are wrong, and poses with them; empty: they are not
  ReasonCode code = ReasonCode::kNone;
};

/// Stereo visual odometry. Fixes the world frame with the first frame and never turns or shifts it.
class VisualOdometry {
 public:
  VisualOdometry(const OdometryConfig& config, const StereoCamera& camera, const Mounting& mounting);
  ~VisualOdometry();

  /// Pose of the frame; the samples are those since the frame before.
  PoseEstimate Track(const StereoFrame& frame, const SensorSamples& samples);
  /// Pose of a moment whose images cannot be used.
  PoseEstimate Bridge(FrameId frame_id, Timestamp t_capture, const SensorSamples& samples,
                      const std::string& reason);

  const Gravity& gravity() const;
  /// What became of the landmarks in the last frame: none of a frame that is bridged.
  const FrameSightings& sightings() const;
  /// What the user should be told, a sentence each, once.
  const std::vector<std::string>& warnings() const;

  /// The pair has turned out to be off, and was never known to be right: what has been mapped is wrong.
  bool pair_was_never_right() const;

  void Apply(const GravityHint& hint);
  /// Holds until another one comes: as long as there is trouble, poses and gravity are in doubt.
  void Hear(const PairTrouble& trouble);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
