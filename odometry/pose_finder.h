// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "odometry/feature_finder.h"
#include "odometry/image_pyramid.h"
#include "odometry/landmark_tracker.h"
#include "odometry/pose_solver.h"
#include "odometry/window.h"

namespace terrace {

/// What is known before a frame is looked at.
struct Expectation {
  Eigen::Isometry3d T_world_seen = Eigen::Isometry3d::Identity();  ///< where the camera was tracked last
  PosePrior prior;
  /// Measured (by an IMU), not only presumed: the prior then has a say in the pose.
  bool measured = false;
  /// Nothing is known: then it takes more to be believed.
  bool lost = false;
  double vertical_px = 0.0;  ///< how much lower the right image is known to be
  std::uint32_t seed = 0;
};

/// Finds the pose of a frame: several guesses of the motion compete, and the one wins that the landmarks
/// known best agree with.
class PoseFinder {
 public:
  PoseFinder(const StereoCamera& camera, const FeatureGrid& grid, int min_inliers);

  struct Found {
    std::vector<Match> matches;
    std::vector<int> tried;  ///< landmarks looked for
    PoseSolution solution;
    double score = 0.0;       ///< sum of the trust in all that agree: one a cell, so old and wide wins
    double share = 0.0;       ///< of the trust in all that was expected
    double mean_trust = 0.0;  ///< of the inliers
    double mean_trust_expected = 0.0;  ///< of all that was expected
    int num_known = 0;                 ///< inliers that have stood still before
    int num_known_tried = 0;           ///< of all that were looked for
    double noise_scale = 1.0;          ///< variance of residuals over what the patches claim
    /// How far off the pose may be, beyond what its information says, because another motion explains nearly
    /// as much: covariance in its own frame; none: no other does.
    std::optional<Matrix6d> doubt;
  };
  /// None when no pose explains enough.
  std::optional<Found> Find(const Window& window, const ImagePyramid& left, const ImagePyramid& right,
                            const Expectation& expected);

  /// Why the last search found none: what agreed was new, and moved against what is known to stand still.
  bool only_strangers() const { return only_strangers_; }
  /// Variance of residuals over what the patches claim: real lenses and calibrations are worse.
  double noise_scale() const { return noise_scale_; }

 private:
  bool Enough(const Found& found, const Expectation& expected) const;
  static bool FollowsStrangers(const Found& found, const Expectation& expected);
  std::vector<PoseConstraint> Constraints(const Window& window, const std::vector<Match>& matches,
                                          double noise_scale) const;
  Found Solve(const Window& window, Matches matches, const PosePrior& prior, std::uint32_t seed,
              double noise_scale) const;
  Found SolveAtItsNoise(const Window& window, const Matches& matches, const PosePrior& prior,
                        std::uint32_t seed) const;
  /// Best first: what explains most, then the other motions that were considered.
  std::vector<Found> FindRoughly(const Window& window, const ImagePyramid& left, const ImagePyramid& right,
                                 const Expectation& expected);
  std::optional<Eigen::Vector2d> ShiftOfImage(const ImagePyramid& left) const;
  std::optional<Matrix6d> Doubt(const Found& fine, const std::vector<Found>& rough,
                                const Expectation& expected) const;
  void UpdateNoiseScale(const PoseSolution& solution);

  StereoCamera camera_;
  LandmarkTracker tracker_;
  int min_inliers_;
  bool only_strangers_ = false;
  cv::Mat1b last_small_;      ///< coarsest level of the image that was tracked last
  double usual_share_ = 0.5;  ///< running mean of Found::share of the rough search
  double noise_scale_ = 1.0;  ///< variance of residuals over what the patches claim
};

}  // namespace terrace
