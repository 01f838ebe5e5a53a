// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "odometry/landmark_tracker.h"
#include "odometry/window.h"

namespace terrace {

/// Follows by how many columns the right image is off. One pair of images cannot tell: its disparities are
/// all wrong by as much, and what they show is possible, if farther or nearer. But what is seen from two
/// places moves in the left image with its true distance, and what is near moves otherwise against what is
/// far than wrong disparities say.
class ColumnMonitor {
 public:
  explicit ColumnMonitor(const StereoCamera& camera) : camera_(camera) {}

  /// Takes in where a tracked frame found the window's landmarks.
  /// @param noise_scale  variance of residuals over what the matches claim
  /// @return what the user should be told, when that changes
  std::optional<std::string> Update(const Window& window, const std::vector<Match>& matches,
                                    const Eigen::Isometry3d& T_world_left, double noise_scale);

  /// Disparities are so much too large, and its standard deviation [px].
  double offset_px() const { return offset_px_; }
  double sigma_px() const;
  bool is_off() const { return is_off_; }
  /// Motion has shown once that they are where they should be.
  bool was_right() const { return was_right_; }
  std::string Reason() const;

 private:
  struct Fit {
    double offset_px = 0.0, information = 0.0, last_step_px = 0.0;
  };
  /// A keyframe that hosts many of the landmarks that are seen.
  struct Host {
    std::vector<const Match*> seen;
    Eigen::Isometry3d T_host_left;
    double information = 0.0;  ///< as one round of the fit says
  };
  std::vector<Host> HostsByInformation(const Window& window, const std::vector<Match>& matches,
                                       const Eigen::Isometry3d& T_world_left, double noise_scale) const;
  Fit FitToHost(const Host& host, const Window& window, double noise_scale, int most_rounds) const;

  /// What is known before anything is seen: calibrations are off by a few columns at most.
  static constexpr double kPriorSigma_px = 3.0;

  StereoCamera camera_;
  double offset_px_ = 0.0;
  double information_ = 1.0 / (kPriorSigma_px * kPriorSigma_px);
  bool is_off_ = false, was_right_ = false;
};

}  // namespace terrace
