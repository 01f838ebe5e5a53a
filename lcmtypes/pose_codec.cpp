// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/pose_codec.h"

#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

/// The covariance of T_world_left, in the left frame, as that of T_world_body = T_world_left * T_left_body,
/// in the body's: with R = R_body_left and t = t_left_body, a rotation w and a translation v of the camera
/// are R w and R (v + w x t) of the body.
Matrix6d InBodyAxes(const Matrix6d& covariance, const Eigen::Isometry3d& T_body_left) {
  const Eigen::Matrix3d& R = T_body_left.linear();
  const Eigen::Vector3d t = T_body_left.inverse().translation();
  Eigen::Matrix3d t_cross;
  t_cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
  Matrix6d transport = Matrix6d::Zero();
  transport.topLeftCorner<3, 3>() = R;
  transport.bottomRightCorner<3, 3>() = R;
  transport.bottomLeftCorner<3, 3>() = -R * t_cross;
  return transport * covariance * transport.transpose();
}

std::optional<BodyVelocity> VelocityOf(const PoseEstimate& pose, const Eigen::Isometry3d& T_body_left,
                                       std::optional<Timestamp> t_prev) {
  if (!t_prev || *t_prev >= pose.t_capture) return std::nullopt;
  const double dt = Seconds(pose.t_capture - *t_prev);
  const Eigen::Isometry3d T_prev_body = T_body_left * pose.T_prev_left * T_body_left.inverse();
  const Eigen::AngleAxisd turn(T_prev_body.linear());
  return BodyVelocity{T_prev_body.linear().transpose() * T_prev_body.translation() / dt,
                      turn.axis() * (turn.angle() / dt)};
}

}  // namespace

BodyPose BodyPoseOf(const PoseEstimate& pose, const Eigen::Isometry3d& T_body_left,
                    std::optional<Timestamp> t_prev, std::int64_t map_id) {
  BodyPose body;
  body.t_capture = pose.t_capture;
  body.map_id = map_id;
  body.epoch = pose.epoch;
  body.status = pose.status;
  body.reason = pose.reason;
  body.reason_code = pose.reason_code;
  if (!pose.reason.empty() && pose.reason_code == ReasonCode::kNone) body.reason_code = ReasonCode::kOther;
  if (pose.status == TrackingStatus::kLost) return body;
  body.T_world_body = pose.T_world_left * T_body_left.inverse();
  body.covariance = InBodyAxes(pose.covariance, T_body_left);
  body.velocity = VelocityOf(pose, T_body_left, t_prev);
  return body;
}

pose_v1_t ToMessage(const BodyPose& pose) {
  pose_v1_t message{};
  message.utime = pose.t_capture.utime();
  message.t_capture_ns = pose.t_capture.ns;
  message.map_id = pose.map_id;
  message.epoch = pose.epoch;
  message.status = static_cast<std::int8_t>(pose.status);
  message.reason_code = static_cast<std::int16_t>(pose.reason_code);
  message.reason = pose.reason;
  message.frame_id = "world";
  if (pose.T_world_body) WritePose(*pose.T_world_body, message.pos, message.quat);
  for (int i = 0; i < 36; ++i) message.cov[i] = pose.covariance(i / 6, i % 6);
  message.has_velocity = pose.velocity.has_value();
  if (pose.velocity) {
    WriteVector(pose.velocity->linear_body, message.vel);
    WriteVector(pose.velocity->angular_body, message.rotation_rate);
  }
  return message;
}

std::optional<BodyPose> FromMessage(const pose_v1_t& message) {
  const auto t_capture = TimeFrom(message.utime, message.t_capture_ns);
  const auto status = EnumFrom<TrackingStatus>(message.status, 3);
  if (!t_capture || !status || message.map_id < 0 || message.epoch < 0) return std::nullopt;
  if (!AllFinite(message.cov) || !AllFinite(message.vel) || !AllFinite(message.rotation_rate))
    return std::nullopt;
  BodyPose pose;
  pose.t_capture = *t_capture;
  pose.map_id = message.map_id;
  pose.epoch = message.epoch;
  pose.status = *status;
  // A later daemon may know more reasons than this program.
  pose.reason_code = EnumFrom<ReasonCode>(message.reason_code, kNumReasonCodes).value_or(ReasonCode::kOther);
  pose.reason = message.reason;
  if (!IsUnknownPose(message.quat)) {
    pose.T_world_body = ReadPose(message.pos, message.quat);
    if (!pose.T_world_body) return std::nullopt;
  } else if (*status != TrackingStatus::kLost) {
    return std::nullopt;
  }
  for (int i = 0; i < 36; ++i) pose.covariance(i / 6, i % 6) = message.cov[i];
  if (message.has_velocity != 0)
    pose.velocity = BodyVelocity{ReadVector(message.vel), ReadVector(message.rotation_rate)};
  return pose;
}

pose_t ToMessage(Timestamp t, const Eigen::Isometry3d& T_world_body) {
  pose_t message{};
  message.utime = t.utime();
  WritePose(T_world_body, message.pos, message.orientation);
  return message;
}

std::optional<Eigen::Isometry3d> FromMessage(const pose_t& message) {
  return ReadPose(message.pos, message.orientation);
}

pose_t ToPoseMessage(const PoseEstimate& pose, const Eigen::Isometry3d& T_body_left,
                     std::optional<Timestamp> t_prev) {
  pose_t message = ToMessage(pose.t_capture, pose.T_world_left * T_body_left.inverse());
  if (const auto velocity = VelocityOf(pose, T_body_left, t_prev)) {
    WriteVector(velocity->linear_body, message.vel);
    WriteVector(velocity->angular_body, message.rotation_rate);
  }
  return message;
}

update_t ToUpdateMessage(const PoseEstimate& pose, std::optional<Timestamp> t_prev) {
  update_t message{};
  message.timestamp = pose.t_capture.utime();
  message.prev_timestamp = t_prev.value_or(pose.t_capture).utime();
  WritePose(pose.T_prev_left, message.translation, message.rotation);
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) message.covariance[row][col] = pose.covariance_prev(row, col);
  }
  message.estimate_status = update_t::ESTIMATE_VALID;
  if (pose.status == TrackingStatus::kBridging)
    message.estimate_status = update_t::ESTIMATE_INSUFFICIENT_FEATURES;
  if (pose.status == TrackingStatus::kLost || !t_prev) message.estimate_status = update_t::NO_DATA;
  return message;
}

}  // namespace terrace
