// SPDX-License-Identifier: BSD-3-Clause
#include "client/pose_history.h"

#include <algorithm>
#include <chrono>

namespace terrace {
namespace {

constexpr std::chrono::milliseconds kTooFarApart(500);
constexpr std::size_t kMaxPoses = 600;  // 10 s at 60 Hz

}  // namespace

void PoseHistory::Add(const BodyPose& pose) {
  if (!poses_.empty() && pose.epoch < poses_.back().epoch) return;
  if (!poses_.empty() && pose.epoch > poses_.back().epoch) poses_.clear();
  const auto place = std::lower_bound(poses_.begin(), poses_.end(), pose.t_capture,
                                      [](const BodyPose& p, Timestamp t) { return p.t_capture < t; });
  if (place != poses_.end() && place->t_capture == pose.t_capture) return;
  poses_.insert(place, pose);
  if (poses_.size() > kMaxPoses) poses_.pop_front();
}

std::optional<BodyPose> PoseHistory::newest() const {
  if (poses_.empty()) return std::nullopt;
  return poses_.back();
}

std::optional<BodyPose> PoseHistory::At(Timestamp t) const {
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), t,
                       [](const BodyPose& p, Timestamp moment) { return p.t_capture < moment; });
  if (after == poses_.end() || !after->T_world_body) return std::nullopt;
  if (after->t_capture == t) return *after;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const auto apart = after->t_capture - before->t_capture;
  if (!before->T_world_body || apart > kTooFarApart) return std::nullopt;
  const double share = Seconds(t - before->t_capture) / Seconds(apart);
  BodyPose pose = before->status > after->status ? *before : *after;
  pose.t_capture = t;
  if (before->covariance.trace() > after->covariance.trace()) pose.covariance = before->covariance;
  const Eigen::Quaterniond from(before->T_world_body->linear());
  const Eigen::Quaterniond to(after->T_world_body->linear());
  pose.T_world_body->linear() = from.slerp(share, to).toRotationMatrix();
  pose.T_world_body->translation() =
      (1.0 - share) * before->T_world_body->translation() + share * after->T_world_body->translation();
  return pose;
}

}  // namespace terrace
