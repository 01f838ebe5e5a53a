// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "odometry/covariance.h"
#include "odometry/credible.h"
#include "odometry/rotation.h"
#include "odometry/visual_odometry_impl.h"

namespace terrace {
namespace {

/// Rad and m: no prediction is better than this.
constexpr double kLeastSigma = 0.001;

}  // namespace

Motion VisualOdometry::Impl::Predict(Timestamp t_capture) const {
  Motion motion = motion_.Predict(*last_, t_capture, window_.keyframes.back(), gravity());
  const bool can_be = IsPose(motion.T_last_left) && CanMove(motion.T_last_left, motion.dt_s) &&
                      motion.covariance.allFinite() && motion.velocity_world.norm() < config_.max_speed_mps;
  if (can_be) return motion;
  Motion rest;
  rest.dt_s = std::max(motion.dt_s, 0.0);
  const double reach_m = config_.max_speed_mps * rest.dt_s;
  rest.covariance.diagonal() << Vector6d::Constant(reach_m * reach_m);
  rest.covariance.diagonal().array() += kLeastSigma * kLeastSigma;
  return rest;
}

bool VisualOdometry::Impl::CanMove(const Eigen::Isometry3d& T_last_left, double dt_s) const {
  constexpr double kSlackM = 0.5;  // of the pose before
  constexpr double kSlackRad = 0.5;
  const double max_turn_rad = config_.max_turn_rate_dps * M_PI / 180.0 * dt_s;
  return T_last_left.translation().norm() < config_.max_speed_mps * dt_s + kSlackM &&
         LogRotation(T_last_left.linear()).norm() < max_turn_rad + kSlackRad;
}

bool VisualOdometry::Impl::CanHaveMovedTo(const Eigen::Isometry3d& T_world_left, double dt_s) const {
  return IsPose(T_world_left) &&
         CanMove(bridging_.T_world_seen().inverse() * T_world_left, bridging_.bridged_s() + dt_s);
}

void VisualOdometry::Impl::LoseTime(Timestamp t_capture) {
  bridging_.LoseTime();
  motion_.LoseTime();
  last_->t_capture = t_capture;
}

ImuSigmas VisualOdometry::Impl::BridgedImu() const {
  if (!motion_.imu_in_use() || Lost()) return ImuSigmas::AtFirst();
  constexpr double kLeast = 0.02;  // m/s: the steps between frames have correlated with the poses
  ImuSigmas known = optimizer_.newest_imu_sigmas();
  const double t = bridging_.bridged_s();
  known.velocity += kLeast + (known.accel_bias + kGravityMagnitude * gravity().sigma_rad) * t;
  return known;
}

Expectation VisualOdometry::Impl::Expected(const StereoFrame& frame, const Motion& predicted) const {
  Expectation expected;
  expected.T_world_seen = bridging_.T_world_seen();
  expected.prior.T_world_left = Chained(last_->T_world_left, predicted.T_last_left);
  expected.prior.information = Inverse(bridging_.SearchCovariance(predicted));
  expected.measured = motion_.imu_in_use();
  if (bridging_.bridged_s() + predicted.dt_s > config_.max_bridging_s) {
    constexpr double kLostSigma = 0.3;  // rad and m: searches go on from there
    expected.prior.information = Matrix6d::Identity() / (kLostSigma * kLostSigma);
    expected.measured = false;
    expected.lost = true;
  }
  expected.vertical_px = vertical_.vertical_px();
  expected.seed = static_cast<std::uint32_t>(frame.frame_id);
  return expected;
}

PoseEstimate VisualOdometry::Impl::Bridged(FrameId frame_id, Timestamp t_capture, const Motion& predicted,
                                           const std::string& reason) {
  const bool was_lost = Lost();
  const double scale = std::sqrt(kCorrelation);
  ImuSigmas known = optimizer_.newest_imu_sigmas();
  known = {scale * known.velocity, scale * known.gyro_bias, scale * known.accel_bias};
  const auto DriftAfter = [&](double t_s) { return motion_.DriftCovariance(t_s, known, gravity()); };
  PoseEstimate pose =
      was_lost ? bridging_.Hold(*last_, predicted.dt_s) : bridging_.Extend(*last_, predicted, DriftAfter);
  pose.frame_id = frame_id;
  pose.t_capture = t_capture;
  pose.status = Lost() ? TrackingStatus::kLost : TrackingStatus::kBridging;
  pose.reason = reason;
  pose.vertical_disparity_px = vertical_.vertical_px();
  if (Lost())
    motion_.Lose();
  else
    motion_.Bridge(predicted, gravity());
  Remember(pose);
  return pose;
}

PoseEstimate VisualOdometry::Impl::Unfound(const StereoFrame& frame, const ImagePyramid& left,
                                           const ImagePyramid& right, const SensorSamples& samples,
                                           const Motion& predicted) {
  constexpr int kMaxStrangeFrames = 4;
  PoseEstimate pose = Bridged(frame.frame_id, frame.t_capture, predicted,
                              pose_finder_.only_strangers() ? "only what moves through the view was found"
                                                            : "too few features found again");
  pose.reason_code =
      pose_finder_.only_strangers() ? ReasonCode::kAmbiguousMotion : ReasonCode::kNotFoundAgain;
  const std::vector<Landmark> landmarks = keyframe_maker_.Look(left, right, vertical_.vertical_px());
  if (static_cast<int>(landmarks.size()) < 2 * config_.min_inliers) {
    pose.reason = "the images show too few features";
    pose.reason_code = ReasonCode::kFewFeatures;
    return pose;
  }
  for (const Keyframe& keyframe : window_.keyframes)
    archive_.Add(keyframe, window_.landmarks, keyframe_covariance_);
  const bool lost = Lost();
  const auto known = archive_.Recognize(left, landmarks, pose.T_world_left, lost ? num_strange_frames_ : 0,
                                        static_cast<std::uint32_t>(frame.frame_id));
  if (known && (lost ? known->num_inliers >= 2 * config_.min_inliers
                     : bridging_.CanReach(known->T_world_left, pose.T_world_left))) {
    pose.status = TrackingStatus::kTracking;
    pose.reason.clear();
    pose.reason_code = ReasonCode::kNone;
    pose.T_world_left = known->T_world_left;
    pose.T_prev_left = last_->T_world_left.inverse() * pose.T_world_left;
    pose.covariance = known->covariance;
    pose.num_inliers = known->num_inliers;
    witness_.Reset();
    Remember(pose);
  } else if (!lost && HasJumped(known, left, landmarks, pose)) {
    return Jumped(std::move(pose));
  } else if (++num_strange_frames_ < kMaxStrangeFrames) {
    return pose;
  }
  num_strange_frames_ = 0;
  // Feet may slip, an IMU may fail: where a sensor and the images have excluded each other, nobody knows.
  const bool contested = !contested_.isZero();
  if (contested && pose.status != TrackingStatus::kTracking) pose.covariance += contested_;
  if (!lost && contested && pose.status != TrackingStatus::kTracking) return pose;
  if (lost && pose.status != TrackingStatus::kTracking) return BeginAnew(frame, left, right, samples);
  const KeyframeState biases = window_.keyframes.back();
  window_ = {};
  AddKeyframe(frame, left, right, pose.T_world_left, {});
  window_.keyframes.back().gyro_bias = biases.gyro_bias;
  window_.keyframes.back().accel_bias = biases.accel_bias;
  window_.keyframes.back().velocity_world = motion_.imu_velocity_world();
  StartWindow(pose.covariance, BridgedImu());
  return pose;
}

bool VisualOdometry::Impl::HasJumped(const std::optional<KeyframeArchive::Recognition>& near,
                                     const ImagePyramid& left, const std::vector<Landmark>& landmarks,
                                     const PoseEstimate& pose) const {
  constexpr double kFar_m = 0.5;  // farther than a bridge of some frames leads astray
  if (num_strange_frames_ == 0) return false;
  const auto known = near ? near
                          : archive_.Recognize(left, landmarks, pose.T_world_left, num_strange_frames_,
                                               static_cast<std::uint32_t>(pose.frame_id));
  return known && known->num_inliers >= 2 * config_.min_inliers &&
         (known->T_world_left.translation() - pose.T_world_left.translation()).norm() > kFar_m;
}

PoseEstimate VisualOdometry::Impl::Jumped(PoseEstimate pose) {
  warnings_.push_back(
      "the images show a place that cannot have been reached: the view has jumped, or a recording begins "
      "anew");
  pose.status = TrackingStatus::kLost;
  pose.reason = warnings_.back();
  pose.reason_code = ReasonCode::kNotFoundAgain;
  bridging_.LoseTime();
  motion_.Lose();
  Remember(pose);
  return pose;
}

}  // namespace terrace
