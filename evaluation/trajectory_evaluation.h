// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "datasets/ground_truth.h"
#include "evaluation/alignment.h"
#include "results/replay_result.h"

namespace terrace {

/// Relative error over pieces of one length: every frame starts one.
struct SegmentError {
  double length_m = 0.0;
  int count = 0;
  double translation_pct = 0.0;     ///< mean
  double rotation_deg_per_m = 0.0;  ///< mean
};

/// Is the covariance honest? Normalised error squared of T_world_left; 6 on average when it is.
struct CovarianceCalibration {
  int count = 0;  ///< frames with a pose, a true pose and a covariance that can be inverted
  double mean_nees = 0.0;
  double mean_nees_rotation = 0.0;     ///< of the three rotations alone; 3 when honest
  double mean_nees_translation = 0.0;  ///< of the three translations alone; 3 when honest
  double share_within_95 = 0.0;        ///< of frames below the 95 % bound of chi-square with 6 degrees
};

/// What one frame adds to the plots.
struct TrajectorySample {
  Timestamp t;
  Eigen::Vector3d p_true = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_aligned = Eigen::Vector3d::Zero();  ///< of the result, aligned by positions
  double error_m = 0.0;                                 ///< distance of the two
  double error_from_first_m = 0.0;                      ///< the same, aligned by the first pose
  double rotation_from_first_deg = 0.0;
  std::optional<double> nees;
};

struct TrajectoryEvaluation {
  std::int64_t num_truth = 0;  ///< true poses that could have been matched
  std::int64_t num_matched = 0;
  double coverage = 0.0;
  double path_length_m = 0.0;  ///< along the matched true poses
  double ate_rmse_m = 0.0;     ///< aligned by positions
  double ate_mean_m = 0.0;
  double ate_max_m = 0.0;
  double ate_first_pose_rmse_m = 0.0;  ///< aligned by the first pose
  double rotation_rmse_deg = 0.0;      ///< aligned by orientations
  double end_error_pct = 0.0;          ///< last position, aligned by the first pose, over the path
  std::vector<SegmentError> segments;  ///< those that fit at least once, ascending
  SegmentError mean_of_all;            ///< over every piece of every length; length_m means nothing
  SegmentError mean_of_kitti;          ///< the same of 100 m and more, as the KITTI benchmark has it
  CovarianceCalibration covariance;
  Eigen::Isometry3d T_true_result = Eigen::Isometry3d::Identity();  ///< by positions, as in `samples`
  std::vector<TrajectorySample> samples;

  /// Of this length; none when no piece was that long.
  const SegmentError* Segment(double length_m) const;
};

/// The true poses as those of the rectified left camera, by calibration alone: R_rect_raw and T_body_left of
/// the result. Throws FileError when the truth is of a body whose camera is not known.
std::vector<TimedPose> TrueLeftPoses(const TrueTrajectory& truth, const ResultCamera& camera);

/// Why MatchPoses has found nothing: one sentence without a full stop. Both must hold poses.
std::string WhyNoneMatches(const std::vector<ResultPose>& result, const std::vector<TimedPose>& truth);

/// Every pose of the result with the nearest true one not more than 2 ms away.
std::vector<PosePair> MatchPoses(const std::vector<ResultPose>& result, const std::vector<TimedPose>& truth);

/// @param num_frames  that the replay was given, dropped ones included: a truth much denser than the frames
///                    (200 Hz beside 20 Hz) can be matched no more often.
TrajectoryEvaluation EvaluateTrajectory(const std::vector<PosePair>& pairs,
                                        const std::vector<ResultFrame>& frames, std::int64_t num_truth,
                                        std::int64_t num_frames);

}  // namespace terrace
