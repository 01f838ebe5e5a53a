// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/motion_model.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "odometry/covariance.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

/// What a motion model knows of the next frame, per second without an image.
constexpr double kModelRotationSigma = 1.0;     // rad / s
constexpr double kModelTranslationSigma = 0.8;  // m / s
constexpr double kGyroRotationSigma = 0.05;     // rad / s
constexpr double kUnknownVelocitySigma = 1.0;   // m / s

Matrix6d DiagonalCovariance(double rotation_sigma, double translation_sigma) {
  Matrix6d m = Matrix6d::Zero();
  m.diagonal().head<3>().setConstant(rotation_sigma * rotation_sigma);
  m.diagonal().tail<3>().setConstant(translation_sigma * translation_sigma);
  return m;
}

}  // namespace

void MotionModel::Read(const SensorSamples& samples, const std::optional<PoseEstimate>& last,
                       Timestamp t_capture, const KeyframeState& biases) {
  IntegrateImu(samples, last, t_capture, biases);
  if (config_.use_priors && mounting_.T_body_left) legs_.Read(samples.priors);
}

Motion MotionModel::Predict(const PoseEstimate& last, Timestamp t_capture, const KeyframeState& biases,
                            const Gravity& gravity) const {
  Motion motion;
  motion.dt_s = Seconds(t_capture - last.t_capture);
  if (imu_in_use_ && imu_gapless_) {
    const ImuState predicted = imu_since_last_->Predict(ImuAt(last.T_world_left, biases), gravity.down_world);
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
    T_world_imu.linear() = predicted.R_world_imu;
    T_world_imu.translation() = predicted.p_world;
    motion.T_last_left = Chained(last.T_world_left.inverse() * T_world_imu, mounting_.T_left_imu->inverse());
    motion.velocity_world = predicted.v_world;
    motion.by_imu = true;
    const double fall_m = 0.5 * kGravityMagnitude * gravity.sigma_rad * motion.dt_s * motion.dt_s;
    motion.covariance = DiagonalCovariance(kGyroRotationSigma * motion.dt_s + 0.001,
                                           imu_velocity_sigma_ * motion.dt_s + fall_m + 0.001);
    return motion;
  }
  if (const std::optional<BodyPrior> step = legs_.step()) {
    motion.T_last_left =
        Chained(mounting_.T_body_left->inverse() * step->T_odom_body, *mounting_.T_body_left);
    motion.velocity_world = imu_velocity_world_;
    motion.by_legs = true;
    constexpr double kLegRotationSigma = 0.01;
    constexpr double kLegTranslationSigma = 0.005;
    motion.covariance = TransportCovariance(*mounting_.T_body_left, step->covariance) +
                        DiagonalCovariance(kLegRotationSigma, kLegTranslationSigma);
    return motion;
  }
  // What the body does just now soon turns into what it does on average.
  constexpr double kMemory_s = 0.1;
  const double now_s = kMemory_s * (1.0 - std::exp(-motion.dt_s / kMemory_s));
  const double later_s = motion.dt_s - now_s;
  motion.T_last_left.linear() = ExpRotation(rotation_rate_ * now_s);
  motion.T_last_left.translation() =
      last.T_world_left.linear().transpose() * (velocity_world_ * now_s + mean_velocity_world_ * later_s);
  motion.velocity_world = imu_velocity_world_;
  motion.covariance =
      DiagonalCovariance(kModelRotationSigma * motion.dt_s, kModelTranslationSigma * motion.dt_s);
  return motion;
}

Matrix6d MotionModel::DriftCovariance(double bridged_s, const ImuSigmas& known,
                                      const Gravity& gravity) const {
  const double t = bridged_s;
  const auto Norm = [](std::initializer_list<double> parts) {
    double sum = 0.0;
    for (const double part : parts) sum += part * part;
    return std::sqrt(sum);
  };
  if (imu_in_use_ && imu_gapless_) {
    const ImuNoise& noise = mounting_.imu_noise;
    const double fall = 0.5 * t * t;
    return DiagonalCovariance(
        Norm({noise.gyro_density * std::sqrt(t), known.gyro_bias * t}),
        Norm({known.velocity * t, known.accel_bias * fall, kGravityMagnitude * gravity.sigma_rad * fall,
              noise.accel_density * std::sqrt(t * t * t / 3.0)}));
  }
  // Measured on rendered walks with gaps: the body swings with its gait, then turns or stops.
  constexpr double kSwing_rad = 0.045;
  constexpr double kSwing_s = 0.15;
  constexpr double kTurn_radps = 0.08;
  constexpr double kSpeed_mps = 0.05;
  constexpr double kShareOfSpeed = 0.3;
  const double rotation = Norm({kSwing_rad * (1.0 - std::exp(-t / kSwing_s)), kTurn_radps * t,
                                mean_rotation_rate_.norm() / std::sqrt(3.0) * t});
  const double translation = Norm({kSpeed_mps * t, kShareOfSpeed * mean_velocity_world_.norm() * t});
  return DiagonalCovariance(rotation, translation);
}

void MotionModel::Correct(const PoseEstimate& last, const PoseEstimate& pose, const Motion& predicted,
                          const KeyframeState& biases, const Gravity& gravity) {
  CorrectImuVelocity(last, pose, predicted, biases, gravity);
  if (mounting_.T_body_left && last.status == TrackingStatus::kTracking)
    legs_.Compare(*mounting_.T_body_left * pose.T_prev_left * mounting_.T_body_left->inverse());
  // After bridging, the step from the last pose is mostly the error of the bridge.
  if (predicted.dt_s <= 0.0 || last.status != TrackingStatus::kTracking) return;
  constexpr double kMeanOver_s = 0.7;
  rotation_rate_ = LogRotation(pose.T_prev_left.linear()) / predicted.dt_s;
  velocity_world_ = (pose.T_world_left.translation() - last.T_world_left.translation()) / predicted.dt_s;
  const double rate = std::min(1.0, predicted.dt_s / kMeanOver_s);
  mean_velocity_world_ += (velocity_world_ - mean_velocity_world_) * rate;
  mean_rotation_rate_ += (rotation_rate_ - mean_rotation_rate_) * rate;
}

void MotionModel::Bridge(const Motion& predicted, const Gravity& gravity) {
  velocity_world_ = mean_velocity_world_;
  rotation_rate_.setZero();
  imu_velocity_world_ = predicted.velocity_world;
  imu_velocity_sigma_ += kGravityMagnitude * gravity.sigma_rad * predicted.dt_s + 0.01 * predicted.dt_s;
}

void MotionModel::Lose() {
  velocity_world_.setZero();
  mean_velocity_world_.setZero();
  rotation_rate_.setZero();
  mean_rotation_rate_.setZero();
  imu_velocity_world_.setZero();
  imu_velocity_sigma_ = kUnknownVelocitySigma;
  keyframe_imu_gapless_ = false;
}

void MotionModel::Restart() {
  Lose();
  imu_in_use_ = false;
  imu_since_last_.reset();
  imu_since_keyframe_.reset();
  legs_.Restart();
}

void MotionModel::FillKeyframe(const KeyframeState& before, Keyframe& keyframe) const {
  if (!imu_in_use_) return;
  keyframe.velocity_world = imu_velocity_world_;
  keyframe.gyro_bias = before.gyro_bias;
  keyframe.accel_bias = before.accel_bias;
  if (keyframe_imu_gapless_) keyframe.imu = imu_since_keyframe_;
}

void MotionModel::RestartKeyframe() {
  imu_since_keyframe_.reset();
  keyframe_imu_gapless_ = true;
}

void MotionModel::RefuseImu() {
  imu_in_use_ = false;
  imu_refused_ = true;
}

/// Sums the IMU up since the last frame and since the newest keyframe.
void MotionModel::IntegrateImu(const SensorSamples& samples, const std::optional<PoseEstimate>& last,
                               Timestamp t_capture, const KeyframeState& biases) {
  if (!config_.use_imu || !mounting_.T_left_imu || imu_refused_) return;
  constexpr double kMaxGap_s = 0.05;
  imu_since_last_ = ImuPreintegration(mounting_.imu_noise, biases.gyro_bias, biases.accel_bias);
  if (!imu_since_keyframe_) imu_since_keyframe_ = imu_since_last_;
  imu_gapless_ = last.has_value();
  Timestamp t = last ? last->t_capture : t_capture;
  const auto AddUntil = [&](const ImuSample& sample, Timestamp until) {
    if (until <= t) return;
    const double dt = Seconds(until - t);
    if (dt > kMaxGap_s) imu_gapless_ = false;
    imu_since_last_->Add(sample.gyro, sample.accel, dt);
    imu_since_keyframe_->Add(sample.gyro, sample.accel, dt);
    t = until;
  };
  for (const ImuSample& sample : samples.imu) {
    ImuSample middle = sample;
    if (newest_sample_ && Seconds(sample.t - newest_sample_->t) < kMaxGap_s) {
      middle.gyro = 0.5 * (sample.gyro + newest_sample_->gyro);
      middle.accel = 0.5 * (sample.accel + newest_sample_->accel);
    }
    AddUntil(middle, std::min(sample.t, t_capture));
    newest_sample_ = sample;
  }
  if (newest_sample_) AddUntil(*newest_sample_, t_capture);
  if (samples.imu.empty()) imu_gapless_ = false;
  if (!imu_gapless_ && last) keyframe_imu_gapless_ = false;
}

/// Velocity of the IMU at a tracked frame: what it was predicted to be, drawn towards what the images saw.
void MotionModel::CorrectImuVelocity(const PoseEstimate& last, const PoseEstimate& pose,
                                     const Motion& predicted, const KeyframeState& biases,
                                     const Gravity& gravity) {
  if (!imu_in_use_ || predicted.dt_s <= 0.0) return;
  const ImuState seen = ImuAt(pose.T_world_left, biases);
  const ImuState before = ImuAt(last.T_world_left, biases);
  constexpr double kSeenSigma = 0.04;
  constexpr double kUnseenSigma = 0.3;
  if (!imu_gapless_) {
    imu_velocity_world_ = (seen.p_world - before.p_world) / predicted.dt_s;
    imu_velocity_sigma_ = kUnseenSigma;
    return;
  }
  // Had the velocity been right, the prediction would have hit the pose.
  const ImuState hit = imu_since_last_->Predict(before, gravity.down_world);
  imu_velocity_world_ = hit.v_world;
  // After bridging, the miss is mostly the error of the bridge.
  if (last.status != TrackingStatus::kTracking) return;
  const double trust = imu_velocity_sigma_ > 0.1 ? 1.0 : 0.4;
  imu_velocity_world_ += trust * (seen.p_world - hit.p_world) / predicted.dt_s;
  imu_velocity_sigma_ = std::max(kSeenSigma, 0.3 * imu_velocity_sigma_);
}

ImuState MotionModel::ImuAt(const Eigen::Isometry3d& T_world_left, const KeyframeState& biases) const {
  const Eigen::Isometry3d T_world_imu = T_world_left * *mounting_.T_left_imu;
  return {T_world_imu.linear(), T_world_imu.translation(), imu_velocity_world_, biases.gyro_bias,
          biases.accel_bias};
}

}  // namespace terrace
