// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/print.h"
#include "odometry/rotation.h"
#include "odometry/visual_odometry_impl.h"

namespace terrace {

void VisualOdometry::Impl::Read(const SensorSamples& samples, Timestamp t_capture) {
  if (config_.use_imu && mounting_.T_left_imu && !motion_.imu_refused()) ReadImu(samples.imu, t_capture);
  if (last_ && Seconds(t_capture - last_->t_capture) > config_.max_bridging_s)
    warnings_.push_back(Printed("no image for %.1f s: the cameras were silent, or the clock was set forward",
                                Seconds(t_capture - last_->t_capture)));
  motion_.Read(samples, last_, t_capture, window_.keyframes.back());
  if (motion_.imu_in_use() || !motion_.has_imu() || window_.keyframes.size() > 1) return;
  // The IMU came after the first image.
  motion_.UseImu();
  gravity_.UseImu();
  StartWindow(keyframe_covariance_);
}

void VisualOdometry::Impl::ReadImu(const std::vector<ImuSample>& samples, Timestamp t_capture) {
  std::optional<std::string> problem = imu_check_.Read(samples, t_capture);
  const std::optional<std::string> clipped = imu_watch_.Read(samples);
  if (!problem) problem = clipped;
  if (problem) return RefuseImu(*problem);
  if (imu_watch_.HasFallenSilent(t_capture))
    warnings_.push_back("the IMU says nothing any more: until it does, nothing is known by it");
}

std::string VisualOdometry::Impl::Frozen(const Motion& predicted) {
  if (standing_.left_alone()) return "the left camera gives the same image again and again: it is frozen";
  constexpr double kMoves_m = 0.01, kMoves_rad = 0.004;  // in a frame; more than a sensor at rest says
  const bool measured = witness_.proven() && (predicted.by_imu || predicted.by_legs);
  const auto moves = [](const Eigen::Isometry3d& T) {
    return T.translation().norm() > kMoves_m || LogRotation(T.linear()).norm() > kMoves_rad;
  };
  frozen_ = standing_.both() && (frozen_ || (measured && moves(predicted.T_last_left)));
  // Who moves does not stop from one frame to the next; what stands for longer may have stopped, if nothing
  // else measures that.
  constexpr int kStops = 5;  // frames
  const bool too_soon = standing_.both() && standing_.num_both() <= kStops && moves(last_->T_prev_left);
  return frozen_ || too_soon ? "both cameras give the same images again and again: they are frozen" : "";
}

void VisualOdometry::Impl::AddUnseen(const Motion& predicted, PoseEstimate* pose) {
  const Vector6d unseen = StepBetween(Eigen::Isometry3d::Identity(), predicted.T_last_left);
  pose->covariance += unseen * unseen.transpose();
}

void VisualOdometry::Impl::RefuseImu(const std::string& why) {
  motion_.RefuseImu();
  witness_.Reset();
  turns_.Reset();
  warnings_.push_back(why + "; the IMU is not used any more");
  gravity_.RefuseImu();
  StartWindow(keyframe_covariance_);
}

Witness::Verdict VisualOdometry::Impl::Hear(const Expectation& expected, const Motion& predicted,
                                            const Eigen::Isometry3d& T_world_found) {
  if (expected.lost)
    return witness_.contradicts() ? Witness::Verdict::kContradicts : Witness::Verdict::kAgrees;
  if (!predicted.by_imu && !predicted.by_legs) return Witness::Verdict::kAgrees;
  return witness_.Hear(StepBetween(expected.prior.T_world_left, T_world_found),
                       bridging_.ExpectedCovariance(predicted), predicted.dt_s);
}

std::optional<std::string> VisualOdometry::Impl::ImuProblem(const Expectation& expected,
                                                            const Motion& predicted,
                                                            const Eigen::Isometry3d& T_world_found) {
  if (expected.lost || !predicted.by_imu) return std::nullopt;
  const Eigen::Matrix3d R_seen_world = expected.T_world_seen.linear().transpose();
  const Eigen::Vector3d by_images = LogRotation(R_seen_world * T_world_found.linear());
  constexpr double kTurns_rad = 0.005;
  if (imu_watch_.stands() && by_images.norm() > kTurns_rad)
    return "the IMU gives the same reading again and again while the images turn: it is frozen";
  turns_.Hear(LogRotation(R_seen_world * expected.prior.T_world_left.linear()), by_images, predicted.dt_s);
  return turns_.Problem();
}

bool VisualOdometry::Impl::WitnessIsWrong(Witness::Verdict verdict, const Motion& predicted) {
  if (predicted.by_imu) return witness_.turns_otherwise();
  return verdict == Witness::Verdict::kDriftsApart || motion_.legs().unproven();
}

PoseEstimate VisualOdometry::Impl::Contradicted(const StereoFrame& frame, const Motion& predicted,
                                                const Eigen::Isometry3d& T_world_found) {
  PoseEstimate pose = Bridged(frame.frame_id, frame.t_capture, predicted, Apart(predicted));
  pose.reason_code = ReasonCode::kAmbiguousMotion;
  const Vector6d apart = StepBetween(pose.T_world_left, T_world_found);
  contested_ = apart * apart.transpose();
  pose.covariance += contested_;
  return pose;
}

void VisualOdometry::Impl::Doubt(const Motion& predicted, PoseEstimate* pose) {
  pose->reason = Apart(predicted);
  pose->reason_code = ReasonCode::kAmbiguousMotion;
  pose->covariance += witness_.apart() * witness_.apart().transpose();
  if (witness_.disagreed_s() < config_.max_bridging_s) return;
  if (predicted.by_imu)
    RefuseImu("the IMU moves otherwise than the images: check its units, T_BS and its clock");
  else
    motion_.legs().Refuse();
  witness_.Reset();
}

std::string VisualOdometry::Impl::Apart(const Motion& predicted) {
  return std::string("the images show another motion than the ") + (predicted.by_imu ? "IMU" : "legs") +
         ": something large moves through the view, or the sensor is wrong";
}

}  // namespace terrace
