// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/world_frame.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace terrace {
namespace {

/// A body leaning more than this against the camera is not a body but some other sensor's axes.
constexpr double kMaxMountingTiltRad = 60.0 * M_PI / 180.0;
/// Body attitude or leg odometry that finds the body this upright says that it is the robot's.
constexpr double kUprightRad = 15.0 * M_PI / 180.0;
/// How well each source knows up, before anything refines it.
constexpr double kMountingSigmaRad = 2.0 * M_PI / 180.0;
constexpr double kAssumedSigmaRad = 15.0 * M_PI / 180.0;
/// Of the roll and pitch of leg odometry, at best.
constexpr double kLegSigmaRad = 1.0 * M_PI / 180.0;
/// A walking robot's accelerations, over the gravity they lean against.
constexpr double kAccelerationSigma = 0.5;
constexpr double kGravity = 9.81;

/// Rotation to the world of a frame in which up and forward are given; forward is made level.
Eigen::Matrix3d LevelRotation(const Eigen::Vector3d& up, const Eigen::Vector3d& forward) {
  const Eigen::Vector3d z = up.normalized();
  Eigen::Vector3d x = forward - forward.dot(z) * z;
  if (x.norm() < 1e-3) x = z.unitOrthogonal();  // looking straight up or down: any yaw is as good
  x.normalize();
  Eigen::Matrix3d R;
  R.row(0) = x;
  R.row(1) = z.cross(x);
  R.row(2) = z;
  return R;
}

/// Whether the robot itself says that the calibration's body is upright.
bool FoundUpright(const SensorSamples& samples) {
  for (const BodyPrior& prior : samples.priors) {
    if (prior.T_odom_body.linear()(2, 2) >= std::cos(kUprightRad)) return true;
  }
  return false;
}

/// Whose roll and pitch are worth less first.
std::vector<BodyPrior> InOrderOfTrust(std::vector<BodyPrior> priors) {
  std::stable_partition(priors.begin(), priors.end(),
                        [](const BodyPrior& prior) { return prior.kind == PriorKind::kLegOdometry; });
  return priors;
}

/// The body, unless it is taken for the axes of a sensor; why, if that is worth a warning.
std::optional<Eigen::Isometry3d> BelievedBody(const OdometryConfig& config, const Mounting& mounting,
                                              const SensorSamples& samples, std::string* warning) {
  if (!mounting.T_body_left || mounting.source == MountingSource::kSensor) return std::nullopt;
  if (mounting.source == MountingSource::kBody) return mounting.T_body_left;
  const Eigen::Vector3d body_up_left = mounting.T_body_left->linear().transpose() * Eigen::Vector3d::UnitZ();
  const double tilt = std::acos(std::clamp(body_up_left.dot(mounting.image_up_left), -1.0, 1.0));
  if (tilt <= kMaxMountingTiltRad || (config.use_priors && FoundUpright(samples)))
    return mounting.T_body_left;
  *warning = "the body's z axis is " + std::to_string(std::lround(tilt * 180.0 / M_PI)) +
             " deg from the camera's up (limit 60 deg): taken for the axes of a sensor, not of a robot; "
             "the world starts at the left camera; if the camera is turned so on the robot, set "
             "camera.mounting.source to body";
  return std::nullopt;
}

}  // namespace

WorldFrame LayWorldFrame(const OdometryConfig& config, const Mounting& mounting,
                         const SensorSamples& samples) {
  WorldFrame world;
  const std::optional<Eigen::Isometry3d> T_body_left =
      BelievedBody(config, mounting, samples, &world.warning);

  Eigen::Vector3d up_left = mounting.image_up_left;
  world.gravity.source = GravitySource::kAssumed;
  world.gravity.sigma_rad = kAssumedSigmaRad;
  if (T_body_left) {
    up_left = T_body_left->linear().transpose() * Eigen::Vector3d::UnitZ();
    world.gravity.source = GravitySource::kMounting;
    world.gravity.sigma_rad = kMountingSigmaRad;
  }
  if (config.use_priors && mounting.T_body_left) {
    for (const BodyPrior& prior : InOrderOfTrust(samples.priors)) {
      const Eigen::Vector3d up_body = prior.T_odom_body.linear().transpose() * Eigen::Vector3d::UnitZ();
      up_left = mounting.T_body_left->linear().transpose() * up_body;
      world.gravity.source = GravitySource::kAttitude;
      world.gravity.sigma_rad =
          std::sqrt(std::max(prior.covariance(0, 0) + prior.covariance(1, 1), 1e-8) / 2.0);
      if (prior.kind == PriorKind::kLegOdometry)
        world.gravity.sigma_rad = std::max(world.gravity.sigma_rad, kLegSigmaRad);
    }
  }
  world.without_imu = world.gravity;
  const Eigen::Vector3d up_without_imu_left = up_left.normalized();
  if (config.use_imu && mounting.T_left_imu && !samples.imu.empty()) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ImuSample& sample : samples.imu) sum += sample.accel;
    const Eigen::Vector3d mean = sum / static_cast<double>(samples.imu.size());
    const Eigen::Vector3d mean_left = mounting.T_left_imu->linear() * mean.normalized();
    // At rest or walking, the mean is near gravity; in free fall or a crash it says nothing about up. Nor
    // does it when it points down.
    constexpr double kOpposite = -0.5;  // cosine of 120 deg
    if (std::abs(mean.norm() - kGravity) < 0.5 * kGravity && mean_left.dot(up_without_imu_left) > kOpposite) {
      up_left = mean_left;
      world.gravity.source = GravitySource::kImu;
      world.gravity.sigma_rad = kAccelerationSigma / kGravity;
    }
  }

  if (T_body_left) {
    const Eigen::Matrix3d R_world_body =
        LevelRotation(T_body_left->linear() * up_left, Eigen::Vector3d::UnitX());
    Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
    T_world_body.linear() = R_world_body;
    world.T_world_left = T_world_body * *T_body_left;
  } else {
    world.T_world_left.linear() = LevelRotation(up_left, Eigen::Vector3d::UnitZ());
  }
  world.gravity.down_world = -Eigen::Vector3d::UnitZ();
  world.without_imu.down_world = -(world.T_world_left.linear() * up_without_imu_left);
  return world;
}

}  // namespace terrace
