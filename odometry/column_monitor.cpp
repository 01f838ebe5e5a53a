// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/column_monitor.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/print.h"
#include "odometry/covariance.h"
#include "odometry/pose_solver.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

constexpr double kOff_px = 0.7;
constexpr double kOffSigmas = 6.0;
/// One landmark's errors resemble its neighbours', as in the pose's covariance; and those of one frame are
/// those of the next, so that what frames know is not summed up, and what is known wears off.
constexpr double kAlikeFrames = 4.5, kKeptOfOld = 0.9;
constexpr std::size_t kFewestOfOneHost = 25;  // landmarks of one keyframe
/// A fit whose last step was longer is none.
constexpr double kConverged_px = 0.1;

using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// Sums of least squares over a pose and one unknown beside it.
struct Normal {
  Matrix6d pose = Matrix6d::Identity() * 1e-6;
  Vector6d pose_offset = Vector6d::Zero(), right = Vector6d::Zero();
  double offset = 1e-6, offset_right = 0.0;

  void Add(const Eigen::Vector3d& residual, const Matrix36& by_pose, const Eigen::Vector3d& by_offset) {
    constexpr double kSoftChi2 = 6.0;  // half-way point of Cauchy's weights
    const double weight = 1.0 / (1.0 + residual.squaredNorm() / kSoftChi2);
    pose.noalias() += weight * by_pose.transpose() * by_pose;
    pose_offset.noalias() += weight * by_pose.transpose() * by_offset;
    right.noalias() -= weight * by_pose.transpose() * residual;
    offset += weight * by_offset.squaredNorm();
    offset_right -= weight * by_offset.dot(residual);
  }
};

}  // namespace

double ColumnMonitor::sigma_px() const { return 1.0 / std::sqrt(std::max(information_, 1e-6)); }

std::string ColumnMonitor::Reason() const {
  return Printed(
      "the columns of the right image are off by %.1f px, by how near and far things move: distances are "
      "wrong; calibrate the pair again",
      std::abs(offset_px_));
}

std::optional<std::string> ColumnMonitor::Update(const Window& window, const std::vector<Match>& matches,
                                                 const Eigen::Isometry3d& T_world_left, double noise_scale) {
  constexpr int kMostRounds = 6;
  Fit best;
  for (const Host& host : HostsByInformation(window, matches, T_world_left, noise_scale)) {
    const Fit fit = FitToHost(host, window, noise_scale, kMostRounds);
    if (std::abs(fit.last_step_px) > kConverged_px || !(fit.information > 0.0)) continue;
    best = fit;
    break;
  }
  const double before = kKeptOfOld * information_, news = best.information / kAlikeFrames;
  // Weighed as if they were independent, which keeps the estimate calm.
  offset_px_ = (before * offset_px_ + news * best.offset_px) / (before + news);
  // A robot that stands learns nothing new, and forgets nothing.
  if (news > 0.01 * information_) information_ = std::max(before, news);
  // It takes evidence to be off, and evidence to be right again: not to know is neither.
  const double off = std::abs(offset_px_), sigma = sigma_px();
  const bool seems_off = is_off_ ? off + 2.0 * sigma > kOff_px : off > kOff_px && off > kOffSigmas * sigma;
  const bool was_off = std::exchange(is_off_, seems_off);
  was_right_ = was_right_ || (!is_off_ && off + 2.0 * sigma < kOff_px);
  if (was_off == is_off_) return std::nullopt;
  return is_off_ ? Reason() : "the columns of the right image are where they should be again";
}

/// One round tells well enough which host says most, at a sixth of the cost of all of them.
std::vector<ColumnMonitor::Host> ColumnMonitor::HostsByInformation(const Window& window,
                                                                   const std::vector<Match>& matches,
                                                                   const Eigen::Isometry3d& T_world_left,
                                                                   double noise_scale) const {
  std::map<KeyframeId, std::vector<const Match*>> of_hosts;
  for (const Match& match : matches)
    if (match.measurement.has_disparity)
      of_hosts[window.landmarks[static_cast<std::size_t>(match.landmark)].host].push_back(&match);
  std::vector<Host> hosts;
  for (auto& [id, seen] : of_hosts) {
    if (seen.size() < kFewestOfOneHost) continue;
    Host host{std::move(seen), window.at(id).T_world_left.inverse() * T_world_left};
    host.information = FitToHost(host, window, noise_scale, 1).information;
    hosts.push_back(std::move(host));
  }
  std::stable_sort(hosts.begin(), hosts.end(),
                   [](const Host& a, const Host& b) { return a.information > b.information; });
  return hosts;
}

ColumnMonitor::Fit ColumnMonitor::FitToHost(const Host& host, const Window& window, double noise_scale,
                                            int most_rounds) const {
  constexpr double kSettled_px = 0.003;
  const double fb = camera_.fx * camera_.baseline_m;
  Eigen::Isometry3d T_host_left = host.T_host_left;
  Fit fit{offset_px_, 0.0, 1.0};
  for (int round = 0; round < most_rounds && std::abs(fit.last_step_px) > kSettled_px; ++round) {
    const Eigen::Isometry3d T_left_host = T_host_left.inverse();
    Normal sums;
    for (const Match* match : host.seen) {
      const Landmark& landmark = window.landmarks[static_cast<std::size_t>(match->landmark)];
      const double w = (landmark.disparity_host_px - fit.offset_px) / fb;
      const Eigen::Vector3d q = T_left_host.linear() * landmark.ray_host + w * T_left_host.translation();
      if (!(q.z() > 0.05)) continue;
      const double inv = 1.0 / q.z();
      Eigen::Matrix3d by_q;
      by_q << camera_.fx * inv, 0, -camera_.fx * q.x() * inv * inv,  //
          0, camera_.fy * inv, -camera_.fy * q.y() * inv * inv,      //
          0, 0, -fb * w * inv * inv;
      const Eigen::Vector3d by_w = by_q * T_left_host.translation() + Eigen::Vector3d(0, 0, fb * inv);
      const Eigen::Matrix3d whitening =
          Whitening(match->measurement, by_w, landmark.disparity_host_sigma_px / fb) /
          std::sqrt(std::max(noise_scale, 1.0));
      const Eigen::Vector3d seen(camera_.fx * q.x() * inv + camera_.cx, camera_.fy * q.y() * inv + camera_.cy,
                                 fb * w * inv + fit.offset_px);
      Matrix36 by_pose;
      by_pose.leftCols<3>() = whitening * by_q * Skew(q);
      by_pose.rightCols<3>() = -w * (whitening * by_q);
      sums.Add(whitening * (seen - match->measurement.uvd), by_pose,
               whitening * (Eigen::Vector3d::UnitZ() - by_w / fb));
    }
    const auto of_offset = SolvePositive(sums.pose, sums.pose_offset),
               of_right = SolvePositive(sums.pose, sums.right);
    if (!of_offset || !of_right) return {};
    fit.information = sums.offset - sums.pose_offset.dot(*of_offset);
    if (!(fit.information > 0.0)) return {};
    fit.last_step_px = (sums.offset_right - sums.pose_offset.dot(*of_right)) / fit.information;
    constexpr double kMostStep_px = 2.0;
    const double taken = std::clamp(fit.last_step_px, -kMostStep_px, kMostStep_px);
    fit.offset_px += taken;
    const Vector6d pose_step = *of_right - taken * *of_offset;
    if (!pose_step.allFinite()) return {};
    T_host_left = Perturb(T_host_left, pose_step);
  }
  return fit;
}

}  // namespace terrace
