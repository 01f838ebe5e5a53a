// SPDX-License-Identifier: BSD-3-Clause
#include "outcome.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "evaluation/alignment.h"
#include "odometry/covariance.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

/// Of rotation (first = 0) or translation (3) alone.
double Chi2OfHalf(const Vector6d& error, const Matrix6d& covariance, int first) {
  Vector6d e = Vector6d::Zero();
  Matrix6d P = Matrix6d::Identity();
  e.segment<3>(first) = error.segment<3>(first);
  P.block<3, 3>(first, first) = covariance.block<3, 3>(first, first);
  return Chi2(e, P);
}

/// Estimated and true poses of the frames that are not lost.
struct TruePairs {
  std::vector<Eigen::Isometry3d> estimated, truth;
  std::vector<const PoseEstimate*> used;
};

TruePairs PairsOf(const std::vector<PoseEstimate>& poses, const Recording& recording) {
  TruePairs pairs;
  for (const PoseEstimate& pose : poses) {
    const auto found = recording.truth.find(std::llround(static_cast<double>(pose.t_capture.ns) * 1e-3));
    if (found == recording.truth.end() || pose.status == TrackingStatus::kLost) continue;
    pairs.estimated.push_back(pose.T_world_left);
    pairs.truth.push_back(found->second);
    pairs.used.push_back(&pose);
  }
  return pairs;
}

/// Two runs of the same digest gave the same poses, bit for bit.
std::size_t DigestOf(const std::vector<PoseEstimate>& poses) {
  std::size_t digest = 0;
  for (const PoseEstimate& pose : poses) {
    for (int k = 0; k < 12; ++k) {
      const double value = pose.T_world_left.matrix()(k % 3, k / 3);
      std::uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      digest = (digest ^ bits) * 1099511628211ull;
    }
  }
  return digest;
}

void MeasureCost(const Trial& trial, Outcome* out) {
  double odometry_s = 0.0;
  for (const double cpu_s : trial.cpu_s) odometry_s += cpu_s;
  out->cpu_ms = 1e3 * odometry_s / out->frames;
  std::vector<double> sorted = trial.cpu_s;
  std::sort(sorted.begin(), sorted.end());
  out->p99_ms = 1e3 * sorted[sorted.size() * 99 / 100];
  out->max_ms = 1e3 * sorted.back();
  out->sgbm_ratio = trial.sgbm_cpu_s / (odometry_s / out->frames);
  out->heap_early_mib = trial.heap_early_mib;
  out->heap_mib = trial.heap_mib;
}

void CountStates(const std::vector<PoseEstimate>& poses, Outcome* out) {
  for (const PoseEstimate& pose : poses) {
    out->tracked += pose.status == TrackingStatus::kTracking;
    out->bridging += pose.status == TrackingStatus::kBridging;
    out->lost += pose.status == TrackingStatus::kLost;
  }
  out->num_epochs = poses.back().epoch + 1;
}

void MeasureReturn(const std::vector<PoseEstimate>& poses, Outcome* out) {
  const Vector6d apart = StepBetween(poses.front().T_world_left, poses.back().T_world_left);
  out->returned_mm = 1e3 * apart.tail<3>().norm();
  out->returned_in_sigmas = std::sqrt(Chi2OfHalf(apart, poses.back().covariance, 3));
}

/// Bridged poses are guesses and say so: they count in the relative errors, not in the ATE.
void MeasureAte(const TruePairs& pairs, Outcome* out) {
  std::vector<PosePair> seen;
  for (std::size_t i = 0; i < pairs.used.size(); ++i)
    if (pairs.used[i]->status == TrackingStatus::kTracking)
      seen.push_back({pairs.used[i]->t_capture, pairs.estimated[i], pairs.truth[i]});
  const Eigen::Isometry3d T_true_result = AlignByPositions(seen);
  double square_m2 = 0.0;
  for (const PosePair& pair : seen)
    square_m2 +=
        (T_true_result * pair.T_result_left.translation() - pair.T_true_left.translation()).squaredNorm();
  out->ate_mm = 1e3 * std::sqrt(square_m2 / static_cast<double>(seen.size()));
}

/// Over stretches of several lengths, and the mean of them.
void MeasureRelative(const TruePairs& pairs, Outcome* out) {
  const std::size_t n = pairs.truth.size();
  std::vector<double> path{0.0};
  for (std::size_t i = 1; i < n; ++i)
    path.push_back(path.back() + (pairs.truth[i].translation() - pairs.truth[i - 1].translation()).norm());
  out->path_m = path.back();
  const bool far = path.back() > 20.0;
  double sum_of_means = 0.0;
  int num_lengths = 0;
  for (const double length : far ? std::vector<double>{10, 20, 30, 40} : std::vector<double>{0.5, 1, 2, 5}) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0, j = 0; i < n; ++i) {
      while (j < n && path[j] < path[i] + length) ++j;
      if (j == n) break;
      const Eigen::Isometry3d delta = (pairs.truth[i].inverse() * pairs.truth[j]).inverse() *
                                      (pairs.estimated[i].inverse() * pairs.estimated[j]);
      sum += delta.translation().norm() / (path[j] - path[i]);
      ++count;
    }
    if (count == 0) continue;
    out->relative_percent[length] = 100.0 * sum / count;
    if (length != 0.5) {
      sum_of_means += 100.0 * sum / count;
      ++num_lengths;
    }
  }
  if (num_lengths > 0) out->mean_relative = sum_of_means / num_lengths;
}

/// Normalised squares of the errors, and jumps from frame to frame.
void MeasureNees(const TruePairs& pairs, Outcome* out) {
  int num_nees = 0;
  for (std::size_t i = 1; i < pairs.truth.size(); ++i) {
    const Eigen::Isometry3d T_true = pairs.truth[0].inverse() * pairs.truth[i];
    const Eigen::Isometry3d T_est = pairs.estimated[0].inverse() * pairs.estimated[i];
    const Vector6d e = StepBetween(T_true, T_est);
    const Matrix6d& P = pairs.used[i]->covariance;
    const double nees = Chi2(e, P);
    out->nees += nees;
    if (pairs.used[i]->status == TrackingStatus::kBridging) out->nees_bridging += nees;
    out->nees_rotation += Chi2OfHalf(e, P, 0);
    out->nees_translation += Chi2OfHalf(e, P, 3);
    ++num_nees;
    const Eigen::Vector3d jump = (pairs.truth[i - 1].inverse() * pairs.truth[i]).translation() -
                                 (pairs.estimated[i - 1].inverse() * pairs.estimated[i]).translation();
    out->max_jump_mm = std::max(out->max_jump_mm, 1e3 * jump.norm());
  }
  out->nees /= num_nees;
  out->nees_bridging /= std::max(out->bridging, 1);
  out->nees_rotation /= num_nees;
  out->nees_translation /= num_nees;
}

void MeasureEnd(const TruePairs& pairs, Outcome* out) {
  const std::size_t n = pairs.truth.size();
  out->end_mm = 1e3 * StepBetween(pairs.truth[0].inverse() * pairs.truth[n - 1],
                                  pairs.estimated[0].inverse() * pairs.estimated[n - 1])
                          .tail<3>()
                          .norm();
  // True gravity is -z of the truth's world, seen through the first poses; it drifts with the estimate's
  // rotation.
  const Eigen::Vector3d down_world_end =
      pairs.estimated[n - 1].linear() * pairs.truth[n - 1].linear().transpose() * -Eigen::Vector3d::UnitZ();
  out->gravity_error_deg =
      180.0 / M_PI * std::acos(std::clamp(down_world_end.dot(out->gravity.down_world), -1.0, 1.0));
}

}  // namespace

Outcome Judge(const Trial& trial, const Recording& recording) {
  Outcome out;
  out.frames = static_cast<int>(trial.poses.size());
  out.gravity = trial.gravity;
  out.digest = DigestOf(trial.poses);
  MeasureCost(trial, &out);
  CountStates(trial.poses, &out);
  MeasureReturn(trial.poses, &out);
  const TruePairs pairs = PairsOf(trial.poses, recording);
  if (pairs.truth.size() < 3) return out;
  MeasureAte(pairs, &out);
  MeasureRelative(pairs, &out);
  MeasureNees(pairs, &out);
  MeasureEnd(pairs, &out);
  return out;
}

void WritePoses(const Trial& trial, const Recording& recording, const std::string& path) {
  const TruePairs pairs = PairsOf(trial.poses, recording);
  std::ofstream file(path);
  file.precision(12);
  const Eigen::Isometry3d T_true_est = pairs.truth.empty()
                                           ? Eigen::Isometry3d::Identity()
                                           : Eigen::Isometry3d(pairs.truth[0] * pairs.estimated[0].inverse());
  for (std::size_t i = 0; i < pairs.used.size(); ++i) {
    const Eigen::Isometry3d est = T_true_est * pairs.estimated[i];
    const Vector6d e = StepBetween(pairs.truth[i], est);
    file << pairs.used[i]->frame_id << ' ' << static_cast<int>(pairs.used[i]->status) << ' '
         << est.translation().transpose() << ' ' << pairs.truth[i].translation().transpose() << ' '
         << e.transpose() << ' ' << pairs.used[i]->covariance.diagonal().cwiseSqrt().transpose() << ' '
         << pairs.used[i]->num_matches << ' ' << pairs.used[i]->num_inliers << ' ' << pairs.used[i]->rms_px
         << ' ' << 1e3 * trial.cpu_s[static_cast<std::size_t>(pairs.used[i]->frame_id)] << '\n';
  }
}

}  // namespace terrace
