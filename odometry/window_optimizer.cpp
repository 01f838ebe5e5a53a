// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/window_optimizer.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "odometry/covariance.h"
#include "odometry/pose_solver.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

/// Half-way point of the Cauchy weights.
constexpr double kSoftResidualChi2 = 6.0;
/// The first pose defines the world; a number keeps the matrix invertible.
constexpr double kFirstPoseSigma = 1e-5;

/// Two axes across a direction, the same for the same direction.
Eigen::Matrix<double, 3, 2> AxesAcross(const Eigen::Vector3d& direction) {
  const PlaneAxes axes = AxesOf(direction);
  Eigen::Matrix<double, 3, 2> m;
  m << axes.x, axes.y;
  return m;
}

KeyframeState Moved(const KeyframeState& state, const Eigen::VectorXd& step, Eigen::Index at, int size) {
  KeyframeState out = state;
  out.T_world_left = Perturb(state.T_world_left, step.segment<6>(at));
  if (size > 6) {
    out.velocity_world += step.segment<3>(at + 6);
    out.gyro_bias += step.segment<3>(at + 9);
    out.accel_bias += step.segment<3>(at + 12);
  }
  return out;
}

}  // namespace

/// H x = -g over keyframes and gravity, and how to get the landmarks back.
struct WindowOptimizer::System {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  std::vector<Point> points;  ///< one for each landmark that has a say
};

/// One eliminated landmark: H_ww w + sum_k W_k x_k = -g_w.
struct WindowOptimizer::Point {
  std::size_t landmark = 0;
  double H = 0.0;
  double g = 0.0;
  std::vector<int> keyframes;  ///< positions in the window; the host first
  std::vector<Vector6d> W;
};

WindowOptimizer::WindowOptimizer(const StereoCamera& camera,
                                 const std::optional<Eigen::Isometry3d>& T_left_imu)
    : camera_(camera), T_left_imu_(T_left_imu) {
  if (T_left_imu_) {
    state_size_ = 15;
    gravity_size_ = 2;
  }
}

void WindowOptimizer::Start(const Keyframe& first, const Matrix6d& pose_covariance, double gravity_sigma_rad,
                            const ImuSigmas& imu) {
  const int n = Dimension(1);
  prior_H_ = Eigen::MatrixXd::Zero(n, n);
  prior_g_ = Eigen::VectorXd::Zero(n);
  Matrix6d covariance = pose_covariance;
  covariance.diagonal().array() += kFirstPoseSigma * kFirstPoseSigma;
  prior_H_.topLeftCorner<6, 6>() = Inverse(covariance);
  if (T_left_imu_) {
    prior_H_.diagonal().segment<3>(6).setConstant(1.0 / (imu.velocity * imu.velocity));
    prior_H_.diagonal().segment<3>(9).setConstant(1.0 / (imu.gyro_bias * imu.gyro_bias));
    prior_H_.diagonal().segment<3>(12).setConstant(1.0 / (imu.accel_bias * imu.accel_bias));
    prior_H_.diagonal().tail<2>().setConstant(1.0 / (gravity_sigma_rad * gravity_sigma_rad));
  }
  prior_states_ = {first};
  newest_covariance_ = pose_covariance;
  if (T_left_imu_) newest_imu_sigmas_ = imu;
  gravity_sigma_rad_ = gravity_sigma_rad;
}

ImuState WindowOptimizer::ImuOf(const KeyframeState& state) const {
  const Eigen::Isometry3d T_world_imu = state.T_world_left * *T_left_imu_;
  return {T_world_imu.linear(), T_world_imu.translation(), state.velocity_world, state.gyro_bias,
          state.accel_bias};
}

Eigen::VectorXd WindowOptimizer::PriorStep(const Window& window, const Eigen::Vector3d& down_world) const {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(prior_g_.size());
  for (std::size_t k = 0; k < prior_states_.size(); ++k) {
    const KeyframeState& from = prior_states_[k];
    const KeyframeState& to = window.keyframes[k];
    const Eigen::Index at = static_cast<Eigen::Index>(k) * state_size_;
    step.segment<6>(at) = StepBetween(from.T_world_left, to.T_world_left);
    if (!T_left_imu_) continue;
    step.segment<3>(at + 6) = to.velocity_world - from.velocity_world;
    step.segment<3>(at + 9) = to.gyro_bias - from.gyro_bias;
    step.segment<3>(at + 12) = to.accel_bias - from.accel_bias;
  }
  if (T_left_imu_) step.tail<2>() = AxesAcross(prior_down_).transpose() * (down_world - prior_down_);
  return step;
}

void WindowOptimizer::AddPrior(const Window& window, const Eigen::Vector3d& down_world, System* system,
                               double* cost) const {
  const Eigen::VectorXd step = PriorStep(window, down_world);
  const Eigen::VectorXd pull = prior_H_ * step;
  *cost += 0.5 * step.dot(pull) + prior_g_.dot(step);
  if (!system) return;
  // The prior's keyframes come first in the window; its gravity goes to the end.
  const Eigen::Index states = static_cast<Eigen::Index>(prior_states_.size()) * state_size_;
  const Eigen::Index n = system->g.size();
  system->H.topLeftCorner(states, states) += prior_H_.topLeftCorner(states, states);
  system->g.head(states) += pull.head(states) + prior_g_.head(states);
  if (!T_left_imu_) return;
  system->H.block(0, n - 2, states, 2) += prior_H_.topRightCorner(states, 2);
  system->H.block(n - 2, 0, 2, states) += prior_H_.bottomLeftCorner(2, states);
  system->H.bottomRightCorner<2, 2>() += prior_H_.bottomRightCorner<2, 2>();
  system->g.tail<2>() += pull.tail<2>() + prior_g_.tail<2>();
}

void WindowOptimizer::AddImu(const Window& window, const Eigen::Vector3d& down_world, bool only_oldest,
                             System* system, double* cost) const {
  if (!T_left_imu_) return;
  /// Beyond this many sigmas an interval is believed less and less: clipping, shocks, lost samples.
  constexpr double kSoftImuChi2 = 60.0;
  // A step of the left camera moves the IMU: rotation by R_imu_left, position through the lever arm.
  const Eigen::Matrix3d R_imu_left = T_left_imu_->linear().transpose();
  const auto FromLeft = [&](const KeyframeState& state) {
    Eigen::Matrix<double, 15, 15> m = Eigen::Matrix<double, 15, 15>::Identity();
    m.block<3, 3>(0, 0) = R_imu_left;
    m.block<3, 3>(3, 0) = -state.T_world_left.linear() * Skew(T_left_imu_->translation());
    m.block<3, 3>(3, 3) = state.T_world_left.linear();
    return m;
  };
  const std::size_t end =
      only_oldest ? std::min<std::size_t>(2, window.keyframes.size()) : window.keyframes.size();
  for (std::size_t k = 1; k < end; ++k) {
    const Keyframe& keyframe = window.keyframes[k];
    if (!keyframe.imu) {
      // Without samples biases still walk slowly; the velocity is anyone's guess.
      if (!system) continue;
      constexpr double kLooseBias = 1e-2;
      const Eigen::Index a = static_cast<Eigen::Index>(k - 1) * 15, b = a + 15;
      for (int i = 6; i < 15; ++i) {
        const double information = i < 9 ? 1e-2 : 1.0 / (kLooseBias * kLooseBias);
        const auto Value = [i](const KeyframeState& s) {
          return i < 9 ? s.velocity_world[i - 6] : i < 12 ? s.gyro_bias[i - 9] : s.accel_bias[i - 12];
        };
        const double difference = Value(keyframe) - Value(window.keyframes[k - 1]);
        system->H(a + i, a + i) += information;
        system->H(b + i, b + i) += information;
        system->H(a + i, b + i) -= information;
        system->H(b + i, a + i) -= information;
        system->g(a + i) -= information * difference;
        system->g(b + i) += information * difference;
      }
      continue;
    }
    const ImuPreintegration::Linearization l =
        keyframe.imu->Linearize(ImuOf(window.keyframes[k - 1]), ImuOf(keyframe), down_world);
    const Eigen::Matrix<double, 15, 15> information = keyframe.imu->Information();
    const double chi2 = l.residual.dot(information * l.residual);
    *cost += 0.5 * kSoftImuChi2 * std::log1p(chi2 / kSoftImuChi2);
    if (!system) continue;
    const Eigen::Matrix<double, 15, 15> weighted = information / (1.0 + chi2 / kSoftImuChi2);
    Eigen::Matrix<double, 15, 32> J;
    J.leftCols<15>() = l.by_start * FromLeft(window.keyframes[k - 1]);
    J.middleCols<15>(15) = l.by_end * FromLeft(keyframe);
    J.rightCols<2>() = l.by_gravity * kGravityMagnitude * AxesAcross(down_world);
    const Eigen::Matrix<double, 32, 15> J_weighted = J.transpose() * weighted;
    const Eigen::Matrix<double, 32, 32> H = J_weighted * J;
    const Eigen::Matrix<double, 32, 1> g = J_weighted * l.residual;
    const Eigen::Index at = static_cast<Eigen::Index>(k - 1) * 15;
    const Eigen::Index n = system->g.size();
    system->H.block<30, 30>(at, at) += H.topLeftCorner<30, 30>();
    system->H.block(at, n - 2, 30, 2) += H.topRightCorner<30, 2>();
    system->H.block(n - 2, at, 2, 30) += H.bottomLeftCorner<2, 30>();
    system->H.bottomRightCorner<2, 2>() += H.bottomRightCorner<2, 2>();
    system->g.segment<30>(at) += g.head<30>();
    system->g.tail<2>() += g.tail<2>();
  }
}

double WindowOptimizer::AddLandmarks(const Window& window, double noise_scale, bool only_oldest,
                                     System* system) const {
  const double fb = camera_.fx * camera_.baseline_m;
  const KeyframeId first = window.keyframes.front().id;
  std::vector<Eigen::Matrix3d> R_left_world;
  for (const Keyframe& keyframe : window.keyframes)
    R_left_world.push_back(keyframe.T_world_left.linear().transpose());

  double cost = 0.0;
  for (std::size_t i = 0; i < window.landmarks.size(); ++i) {
    const Landmark& landmark = window.landmarks[i];
    if (landmark.observations.empty() || (only_oldest && landmark.host != first)) continue;
    const auto h = static_cast<std::size_t>(landmark.host - first);
    const Eigen::Isometry3d& T_world_host = window.keyframes[h].T_world_left;
    const double w = landmark.inverse_depth;

    Point point;
    point.landmark = i;
    const double host_sigma = landmark.disparity_host_sigma_px * std::sqrt(noise_scale);
    const double host_residual = (fb * w - landmark.disparity_host_px) / host_sigma;
    cost += 0.5 * host_residual * host_residual;
    if (system) {
      point.H = fb * fb / (host_sigma * host_sigma);
      point.g = fb / host_sigma * host_residual;
      point.keyframes.push_back(static_cast<int>(h));
      point.W.push_back(Vector6d::Zero());
    }
    for (const Observation& observation : landmark.observations) {
      const auto t = static_cast<std::size_t>(observation.keyframe - first);
      const Keyframe& target = window.keyframes[t];
      const Eigen::Matrix3d R_target_host = R_left_world[t] * T_world_host.linear();
      const Eigen::Vector3d apart =
          R_left_world[t] * (T_world_host.translation() - target.T_world_left.translation());
      const Eigen::Vector3d q = R_target_host * landmark.ray_host + w * apart;
      if (!(q.z() > 0.02)) continue;
      const double inv = 1.0 / q.z();
      const Eigen::Vector3d predicted(camera_.fx * q.x() * inv + camera_.cx,
                                      camera_.fy * q.y() * inv + camera_.cy, fb * w * inv);
      const Eigen::Matrix3d whitening =
          Whitening(observation.measurement, Eigen::Vector3d::Zero(), 0.0) / std::sqrt(noise_scale);
      const Eigen::Vector3d r = whitening * (predicted - observation.measurement.uvd);
      const double chi2 = r.squaredNorm();
      cost += 0.5 * kSoftResidualChi2 * std::log1p(chi2 / kSoftResidualChi2);
      if (!system) continue;

      const double weight = 1.0 / (1.0 + chi2 / kSoftResidualChi2);
      Eigen::Matrix3d by_q;
      by_q << camera_.fx * inv, 0, -camera_.fx * q.x() * inv * inv,  //
          0, camera_.fy * inv, -camera_.fy * q.y() * inv * inv,      //
          0, 0, -fb * w * inv * inv;
      by_q = whitening * by_q;
      Eigen::Matrix<double, 3, 6> J_host, J_target;
      J_host.leftCols<3>().noalias() = -by_q * R_target_host * Skew(landmark.ray_host);
      J_host.rightCols<3>().noalias() = by_q * R_target_host * w;
      J_target.leftCols<3>().noalias() = by_q * Skew(q);
      J_target.rightCols<3>() = -w * by_q;
      const Eigen::Vector3d J_w = by_q * apart + whitening.col(2) * (fb * inv);

      const Eigen::Index a = static_cast<Eigen::Index>(h) * state_size_;
      const Eigen::Index b = static_cast<Eigen::Index>(t) * state_size_;
      const Eigen::Matrix<double, 6, 3> host_weighted = weight * J_host.transpose();
      const Eigen::Matrix<double, 6, 3> target_weighted = weight * J_target.transpose();
      system->H.block<6, 6>(a, a).noalias() += host_weighted * J_host;
      system->H.block<6, 6>(b, b).noalias() += target_weighted * J_target;
      const Matrix6d cross = host_weighted * J_target;
      system->H.block<6, 6>(a, b) += cross;
      system->H.block<6, 6>(b, a) += cross.transpose();
      system->g.segment<6>(a).noalias() += host_weighted * r;
      system->g.segment<6>(b).noalias() += target_weighted * r;
      point.H += weight * J_w.squaredNorm();
      point.g += weight * J_w.dot(r);
      point.W[0].noalias() += host_weighted * J_w;
      point.keyframes.push_back(static_cast<int>(t));
      point.W.push_back(target_weighted * J_w);
    }
    if (!system) continue;

    // Eliminate the landmark.
    const double inverse = 1.0 / point.H;
    for (std::size_t m = 0; m < point.keyframes.size(); ++m) {
      const Eigen::Index a = static_cast<Eigen::Index>(point.keyframes[m]) * state_size_;
      system->g.segment<6>(a) -= point.W[m] * (inverse * point.g);
      for (std::size_t k = 0; k < point.keyframes.size(); ++k) {
        const Eigen::Index b = static_cast<Eigen::Index>(point.keyframes[k]) * state_size_;
        system->H.block<6, 6>(a, b).noalias() -= (inverse * point.W[m]) * point.W[k].transpose();
      }
    }
    system->points.push_back(std::move(point));
  }
  return cost;
}

double WindowOptimizer::Build(const Window& window, const Eigen::Vector3d& down_world, double noise_scale,
                              bool only_oldest, System* system) const {
  if (system) {
    const int n = Dimension(window.keyframes.size());
    system->H = Eigen::MatrixXd::Zero(n, n);
    system->g = Eigen::VectorXd::Zero(n);
    system->points.clear();
  }
  double cost = AddLandmarks(window, noise_scale, only_oldest, system);
  AddPrior(window, down_world, system, &cost);
  AddImu(window, down_world, only_oldest, system, &cost);
  return cost;
}

void WindowOptimizer::Optimize(Window& window, Eigen::Vector3d& down_world, double noise_scale,
                               int max_iterations) {
  double damping = 1e-5;
  System system;
  double cost = Build(window, down_world, noise_scale, false, &system);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    Eigen::MatrixXd damped = system.H;
    damped.diagonal() += damping * system.H.diagonal();
    const Eigen::VectorXd step = damped.ldlt().solve(-system.g);
    if (!step.allFinite()) break;

    // Try the step on copies of the small things only.
    std::vector<KeyframeState> states_before(window.keyframes.begin(), window.keyframes.end());
    std::vector<double> depths_before;
    const Eigen::Vector3d down_before = down_world;
    for (std::size_t k = 0; k < window.keyframes.size(); ++k) {
      KeyframeState& state = window.keyframes[k];
      state = Moved(state, step, static_cast<Eigen::Index>(k) * state_size_, state_size_);
    }
    if (T_left_imu_) down_world = (down_world + AxesAcross(down_world) * step.tail<2>()).normalized();
    for (const Point& point : system.points) {
      double right = -point.g;
      for (std::size_t m = 0; m < point.keyframes.size(); ++m)
        right -= point.W[m].dot(step.segment<6>(static_cast<Eigen::Index>(point.keyframes[m]) * state_size_));
      Landmark& landmark = window.landmarks[point.landmark];
      depths_before.push_back(landmark.inverse_depth);
      landmark.inverse_depth = std::max(landmark.inverse_depth + right / point.H, 1e-6);
    }

    System next;
    const double next_cost = Build(window, down_world, noise_scale, false, &next);
    if (next_cost > cost) {
      for (std::size_t k = 0; k < window.keyframes.size(); ++k)
        static_cast<KeyframeState&>(window.keyframes[k]) = states_before[k];
      down_world = down_before;
      for (std::size_t i = 0; i < system.points.size(); ++i)
        window.landmarks[system.points[i].landmark].inverse_depth = depths_before[i];
      damping *= 100.0;
      continue;
    }
    constexpr double kEnough = 1e-3;  // of the cost
    const bool settled = cost - next_cost < kEnough * cost;
    cost = next_cost;
    system = std::move(next);
    damping *= 0.1;
    if (settled) break;
  }

  for (const Point& point : system.points)
    window.landmarks[point.landmark].inverse_depth_sigma = std::sqrt(1.0 / point.H);
  const Eigen::Index n = system.g.size();
  const Eigen::Index newest = static_cast<Eigen::Index>(window.keyframes.size() - 1) * state_size_;
  Eigen::MatrixXd wanted = Eigen::MatrixXd::Zero(n, state_size_ + gravity_size_);
  wanted.block(newest, 0, state_size_, state_size_).setIdentity();
  if (T_left_imu_) wanted.bottomRightCorner<2, 2>().setIdentity();
  const Eigen::MatrixXd columns = system.H.ldlt().solve(wanted);
  newest_covariance_ = columns.block<6, 6>(newest, 0);
  newest_covariance_ = (0.5 * (newest_covariance_ + newest_covariance_.transpose())).eval();
  if (!T_left_imu_) return;
  const auto SigmaAt = [&](Eigen::Index first) {
    return std::sqrt(std::max(columns.block<3, 3>(newest + first, first).trace() / 3.0, 0.0));
  };
  newest_imu_sigmas_ = {SigmaAt(6), SigmaAt(9), SigmaAt(12)};
  gravity_sigma_rad_ = std::sqrt(std::max(0.5 * columns.bottomRightCorner<2, 2>().trace(), 0.0));
}

void WindowOptimizer::DropOldest(Window& window, const Eigen::Vector3d& down_world, double noise_scale) {
  System system;
  Build(window, down_world, noise_scale, true, &system);
  const Eigen::Index m = state_size_;
  const Eigen::Index rest = system.g.size() - m;
  Eigen::MatrixXd H_mm = system.H.topLeftCorner(m, m);
  H_mm.diagonal().array() += 1e-9;
  const Eigen::LDLT<Eigen::MatrixXd> solver(H_mm);
  const Eigen::MatrixXd H_mr = system.H.topRightCorner(m, rest);
  prior_H_ = system.H.bottomRightCorner(rest, rest) - H_mr.transpose() * solver.solve(H_mr);
  prior_H_ = (0.5 * (prior_H_ + prior_H_.transpose())).eval();
  prior_g_ = system.g.tail(rest) - H_mr.transpose() * solver.solve(system.g.head(m));

  const KeyframeId gone = window.keyframes.front().id;
  window.keyframes.pop_front();
  std::erase_if(window.landmarks, [gone](const Landmark& landmark) { return landmark.host == gone; });
  prior_states_.assign(window.keyframes.begin(), window.keyframes.end());
  prior_down_ = down_world;
}

}  // namespace terrace
