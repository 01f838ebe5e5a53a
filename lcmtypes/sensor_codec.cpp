// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/sensor_codec.h"

#include "lcmtypes/codec_values.h"

namespace terrace {

imu_v1_t ToMessage(const ImuSample& sample) {
  imu_v1_t message{};
  message.utime = sample.t.utime();
  message.t_ns = sample.t.ns;
  WriteVector(sample.gyro, message.gyro);
  WriteVector(sample.accel, message.accel);
  return message;
}

std::optional<ImuSample> FromMessage(const imu_v1_t& message) {
  const std::optional<Timestamp> t = TimeFromNanoseconds(message.t_ns);
  if (!t || !AllFinite(message.gyro) || !AllFinite(message.accel)) return std::nullopt;
  return ImuSample{*t, ReadVector(message.gyro), ReadVector(message.accel)};
}

body_prior_v1_t ToMessage(const BodyPrior& prior) {
  body_prior_v1_t message{};
  message.utime = prior.t.utime();
  message.t_ns = prior.t.ns;
  message.kind = static_cast<std::int8_t>(prior.kind);
  WritePose(prior.T_odom_body, message.pos, message.quat);
  for (int i = 0; i < 36; ++i) message.cov[i] = prior.covariance(i / 6, i % 6);
  return message;
}

std::optional<BodyPrior> FromMessage(const body_prior_v1_t& message) {
  const std::optional<Eigen::Isometry3d> T_odom_body = ReadPose(message.pos, message.quat);
  const std::optional<Timestamp> t = TimeFromNanoseconds(message.t_ns);
  if (!t || !T_odom_body || !AllFinite(message.cov)) return std::nullopt;
  if (message.kind != body_prior_v1_t::ATTITUDE && message.kind != body_prior_v1_t::LEG_ODOMETRY)
    return std::nullopt;
  BodyPrior prior;
  prior.t = *t;
  prior.kind = static_cast<PriorKind>(message.kind);
  prior.T_odom_body = *T_odom_body;
  for (int i = 0; i < 36; ++i) prior.covariance(i / 6, i % 6) = message.cov[i];
  return prior;
}

std::optional<BodyPrior> PriorFromPose(const pose_t& message, PriorKind kind) {
  const std::optional<Eigen::Isometry3d> T_odom_body = ReadPose(message.pos, message.orientation);
  const std::optional<Timestamp> t = TimeFromMicroseconds(message.utime);
  if (!t || !T_odom_body) return std::nullopt;
  return BodyPrior{*t, kind, *T_odom_body, Matrix6d::Zero()};
}

}  // namespace terrace
