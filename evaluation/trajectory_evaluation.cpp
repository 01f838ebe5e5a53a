// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/trajectory_evaluation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>

#include "core/angles.h"
#include "core/file_bytes.h"
#include "core/print.h"
#include "evaluation/statistics.h"

namespace terrace {
namespace {

constexpr std::int64_t kMatchWithinNs = 2'000'000;
/// Short pieces for robots that walk, then those for longer walks, then those of the KITTI benchmark.
constexpr double kSegmentLengths_m[] = {1, 2, 5, 10, 20, 30, 40, 100, 200, 300, 400, 500, 600, 700, 800};
constexpr double kKittiMinLength_m = 100.0;
/// Rounding must not push the end of a piece of exactly the wanted length one frame further.
constexpr double kLengthSlack_m = 1e-9;
/// A truth with more poses than this times the frames is a denser recording, not missing frames.
constexpr double kDenseTruthFactor = 1.5;
/// 95 % of chi-square with 6 degrees of freedom.
constexpr double kChiSquare6At95 = 12.592;

double AngleOf(const Eigen::Matrix3d& rotation) { return Eigen::AngleAxisd(rotation).angle(); }

Eigen::Vector3d RotationVector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd angle_axis(rotation);
  return angle_axis.angle() * angle_axis.axis();
}

std::vector<double> PathLengths(const std::vector<PosePair>& pairs) {
  std::vector<double> along(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    along[i] =
        along[i - 1] + (pairs[i].T_true_left.translation() - pairs[i - 1].T_true_left.translation()).norm();
  }
  return along;
}

/// For every start frame the first frame at least `length_m` further along the true path, as the KITTI
/// benchmark does (Geiger et al. 2012).
SegmentError ErrorOverSegments(const std::vector<PosePair>& pairs, const std::vector<double>& along,
                               double length_m) {
  SegmentError error;
  error.length_m = length_m;
  std::size_t end = 0;
  for (std::size_t start = 0; start < pairs.size(); ++start) {
    while (end < pairs.size() && along[end] - along[start] < length_m - kLengthSlack_m) ++end;
    if (end == pairs.size()) break;
    const Eigen::Isometry3d moved_result = pairs[start].T_result_left.inverse() * pairs[end].T_result_left;
    const Eigen::Isometry3d moved_true = pairs[start].T_true_left.inverse() * pairs[end].T_true_left;
    const Eigen::Isometry3d difference = moved_result.inverse() * moved_true;
    error.translation_pct += 100.0 * difference.translation().norm() / length_m;
    error.rotation_deg_per_m += Degrees(AngleOf(difference.linear())) / length_m;
    ++error.count;
  }
  if (error.count > 0) {
    error.translation_pct /= error.count;
    error.rotation_deg_per_m /= error.count;
  }
  return error;
}

SegmentError MeanOfSegments(const std::vector<SegmentError>& segments, double min_length_m) {
  SegmentError mean;
  for (const SegmentError& segment : segments) {
    if (segment.length_m < min_length_m) continue;
    mean.count += segment.count;
    mean.translation_pct += segment.count * segment.translation_pct;
    mean.rotation_deg_per_m += segment.count * segment.rotation_deg_per_m;
  }
  if (mean.count > 0) {
    mean.translation_pct /= mean.count;
    mean.rotation_deg_per_m /= mean.count;
  }
  return mean;
}

/// e^T P^-1 e; none when P cannot be inverted, as that of the first frame, which is zero.
template <int N>
std::optional<double> NormalisedSquare(const Eigen::Matrix<double, N, 1>& error,
                                       const Eigen::Matrix<double, N, N>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, N, N>> factor(covariance);
  if (factor.info() != Eigen::Success || !(factor.matrixLLT().diagonal().minCoeff() > 0.0)) {
    return std::nullopt;
  }
  const double square = error.dot(factor.solve(error));
  return std::isfinite(square) ? std::optional(square) : std::nullopt;
}

/// Error of T_world_left with both worlds put where the first pose is: rotation [rad] and translation [m] in
/// the left frame, so that T_true * (rotation, translation) = T_result.
Vector6d PoseError(const PosePair& first, const PosePair& pair) {
  const Eigen::Isometry3d since_first_result = first.T_result_left.inverse() * pair.T_result_left;
  const Eigen::Isometry3d since_first_true = first.T_true_left.inverse() * pair.T_true_left;
  const Eigen::Isometry3d error = since_first_true.inverse() * since_first_result;
  Vector6d v;
  v << RotationVector(error.linear()), error.translation();
  return v;
}

/// Fills `nees` of the samples and returns what they say together.
CovarianceCalibration Calibrate(const std::vector<PosePair>& pairs, const std::vector<ResultFrame>& frames,
                                std::vector<TrajectorySample>* samples) {
  std::map<Timestamp, const Matrix6d*> covariances;
  for (const ResultFrame& frame : frames) {
    if (frame.covariance) covariances[frame.t_capture] = &*frame.covariance;
  }
  CovarianceCalibration calibration;
  int num_within_95 = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto covariance = covariances.find(pairs[i].t);
    if (covariance == covariances.end()) continue;
    const Matrix6d& P = *covariance->second;
    const Vector6d error = PoseError(pairs.front(), pairs[i]);
    const std::optional<double> nees = NormalisedSquare<6>(error, P);
    const std::optional<double> rotation = NormalisedSquare<3>(error.head<3>(), P.topLeftCorner<3, 3>());
    const std::optional<double> translation =
        NormalisedSquare<3>(error.tail<3>(), P.bottomRightCorner<3, 3>());
    if (!nees || !rotation || !translation) continue;
    ++calibration.count;
    calibration.mean_nees += *nees;
    calibration.mean_nees_rotation += *rotation;
    calibration.mean_nees_translation += *translation;
    num_within_95 += *nees <= kChiSquare6At95;
    (*samples)[i].nees = *nees;
  }
  if (calibration.count > 0) {
    calibration.mean_nees /= calibration.count;
    calibration.mean_nees_rotation /= calibration.count;
    calibration.mean_nees_translation /= calibration.count;
    calibration.share_within_95 = static_cast<double>(num_within_95) / calibration.count;
  }
  return calibration;
}

}  // namespace

const SegmentError* TrajectoryEvaluation::Segment(double length_m) const {
  for (const SegmentError& segment : segments) {
    if (segment.length_m == length_m) return &segment;
  }
  return nullptr;
}

std::vector<TimedPose> TrueLeftPoses(const TrueTrajectory& truth, const ResultCamera& camera) {
  Eigen::Isometry3d T_frame_left = Eigen::Isometry3d::Identity();
  if (truth.frame == TruthFrame::kRawLeft) T_frame_left.linear() = camera.R_rect_raw.transpose();
  if (truth.frame == TruthFrame::kBody) {
    if (!camera.T_body_left) {
      throw FileError("camera.json: T_body_left is null, but the true poses are those of the body");
    }
    T_frame_left = *camera.T_body_left;
  }
  std::vector<TimedPose> poses = truth.poses;
  for (TimedPose& pose : poses) pose.T_world_frame = pose.T_world_frame * T_frame_left;
  return poses;
}

std::vector<PosePair> MatchPoses(const std::vector<ResultPose>& result, const std::vector<TimedPose>& truth) {
  std::vector<PosePair> pairs;
  for (const ResultPose& pose : result) {
    auto next = std::lower_bound(truth.begin(), truth.end(), pose.t_capture,
                                 [](const TimedPose& p, Timestamp t) { return p.t < t; });
    if (next == truth.end() ||
        (next != truth.begin() && pose.t_capture - std::prev(next)->t < next->t - pose.t_capture)) {
      if (next == truth.begin()) continue;
      --next;
    }
    if (std::abs((next->t - pose.t_capture).count()) > kMatchWithinNs) continue;
    pairs.push_back({pose.t_capture, pose.T_world_left, next->T_world_frame});
  }
  return pairs;
}

std::string WhyNoneMatches(const std::vector<ResultPose>& result, const std::vector<TimedPose>& truth) {
  const auto seconds = [](Timestamp t) { return 1e-9 * static_cast<double>(t.ns); };
  const double result_begin_s = seconds(result.front().t_capture),
               result_end_s = seconds(result.back().t_capture);
  const double truth_begin_s = seconds(truth.front().t), truth_end_s = seconds(truth.back().t);
  std::string text = Printed(
      "no pose has a true one within 2 ms: the poses are of %.3f to %.3f s, the true ones of "
      "%.3f to %.3f s",
      result_begin_s, result_end_s, truth_begin_s, truth_end_s);
  const bool overlap = truth_begin_s <= result_end_s && truth_end_s >= result_begin_s;
  // Counted from a start of one's own, times near zero overlap in every unit.
  for (const double factor : {1e3, 1e6, 1e9, 1e-3, 1e-6, 1e-9}) {
    if (overlap || truth_begin_s <= 0.0) break;
    if (factor * truth_begin_s > result_end_s || factor * truth_end_s < result_begin_s) continue;
    text += Printed("; the true ones are in another unit, with the factor %g they would meet", factor);
    break;
  }
  return text;
}

TrajectoryEvaluation EvaluateTrajectory(const std::vector<PosePair>& pairs,
                                        const std::vector<ResultFrame>& frames, std::int64_t num_truth,
                                        std::int64_t num_frames) {
  TrajectoryEvaluation evaluation;
  const bool dense = static_cast<double>(num_truth) > kDenseTruthFactor * static_cast<double>(num_frames);
  evaluation.num_truth = dense ? num_frames : num_truth;
  evaluation.num_matched = static_cast<std::int64_t>(pairs.size());
  if (evaluation.num_truth > 0) {
    evaluation.coverage =
        static_cast<double>(evaluation.num_matched) / static_cast<double>(evaluation.num_truth);
  }
  if (pairs.empty()) return evaluation;

  const Eigen::Isometry3d T_by_positions = AlignByPositions(pairs);
  evaluation.T_true_result = T_by_positions;
  const Eigen::Isometry3d T_by_first = AlignByFirstPose(pairs);
  const Eigen::Isometry3d T_by_orientations = AlignByOrientations(pairs);
  std::vector<double> errors_m, errors_from_first_m, rotation_errors_deg;
  for (const PosePair& pair : pairs) {
    TrajectorySample sample;
    sample.t = pair.t;
    sample.p_true = pair.T_true_left.translation();
    sample.p_aligned = T_by_positions * pair.T_result_left.translation();
    sample.error_m = (sample.p_aligned - sample.p_true).norm();
    const Eigen::Isometry3d from_first = pair.T_true_left.inverse() * T_by_first * pair.T_result_left;
    sample.error_from_first_m = from_first.translation().norm();
    sample.rotation_from_first_deg = Degrees(AngleOf(from_first.linear()));
    evaluation.samples.push_back(sample);
    errors_m.push_back(sample.error_m);
    errors_from_first_m.push_back(sample.error_from_first_m);
    rotation_errors_deg.push_back(Degrees(AngleOf(pair.T_true_left.linear().transpose() *
                                                  T_by_orientations.linear() * pair.T_result_left.linear())));
  }
  const std::vector<double> along = PathLengths(pairs);
  evaluation.path_length_m = along.back();
  evaluation.ate_rmse_m = RmsOf(errors_m);
  evaluation.ate_mean_m = MeanOf(errors_m);
  evaluation.ate_max_m = *std::max_element(errors_m.begin(), errors_m.end());
  evaluation.ate_first_pose_rmse_m = RmsOf(errors_from_first_m);
  evaluation.rotation_rmse_deg = RmsOf(rotation_errors_deg);
  if (along.back() > 0.0) evaluation.end_error_pct = 100.0 * errors_from_first_m.back() / along.back();
  for (double length_m : kSegmentLengths_m) {
    const SegmentError error = ErrorOverSegments(pairs, along, length_m);
    if (error.count > 0) evaluation.segments.push_back(error);
  }
  evaluation.mean_of_all = MeanOfSegments(evaluation.segments, 0.0);
  evaluation.mean_of_kitti = MeanOfSegments(evaluation.segments, kKittiMinLength_m);
  evaluation.covariance = Calibrate(pairs, frames, &evaluation.samples);
  return evaluation;
}

}  // namespace terrace
