// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/pose_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <Eigen/Dense>

#include "odometry/covariance.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

/// Beyond this a point is not where it was expected: 99.9 % of three normal components lie below 16.3.
constexpr double kMaxChi2 = 16.0;
/// Half-way point of the Cauchy weights.
constexpr double kSoftChi2 = 6.0;

using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// Whitened residual; false behind the camera.
bool Residual(const PoseConstraint& c, const Eigen::Matrix3d& R_left_world, const Eigen::Vector3d& t_world,
              const StereoCamera& camera, Eigen::Vector3d& residual, Matrix36* jacobian) {
  const Eigen::Vector3d q = R_left_world * (c.point_world - c.inverse_depth * t_world);
  if (!(q.z() > 1e-3)) return false;
  const double inv = 1.0 / q.z();
  const double fb = camera.fx * camera.baseline_m;
  const Eigen::Vector3d predicted(camera.fx * q.x() * inv + camera.cx, camera.fy * q.y() * inv + camera.cy,
                                  fb * c.inverse_depth * inv);
  residual = c.whitening * (predicted - c.uvd);
  if (jacobian) {
    Eigen::Matrix3d by_q;
    by_q << camera.fx * inv, 0, -camera.fx * q.x() * inv * inv,  //
        0, camera.fy * inv, -camera.fy * q.y() * inv * inv,      //
        0, 0, -fb * c.inverse_depth * inv * inv;
    by_q = c.whitening * by_q;
    jacobian->leftCols<3>() = by_q * Skew(q);
    jacobian->rightCols<3>() = -c.inverse_depth * by_q;
  }
  return true;
}

/// Truncated squared error over all constraints: what a hypothesis is judged by.
double Cost(const std::vector<PoseConstraint>& constraints, const Eigen::Isometry3d& T_world_left,
            const StereoCamera& camera) {
  const Eigen::Matrix3d R = T_world_left.linear().transpose();
  const Eigen::Vector3d t = T_world_left.translation();
  double cost = 0.0;
  Eigen::Vector3d r;
  for (const PoseConstraint& c : constraints)
    cost +=
        c.trust * (Residual(c, R, t, camera, r, nullptr) ? std::min(r.squaredNorm(), kMaxChi2) : kMaxChi2);
  return cost;
}

Vector6d PriorStep(const PosePrior& prior, const Eigen::Isometry3d& T) {
  return StepBetween(prior.T_world_left, T);
}

/// Gauss-Newton over some of the constraints. soft_chi2 <= 0: all weigh the same.
template <typename Indices>
bool Refine(const std::vector<PoseConstraint>& constraints, const Indices& used, const PosePrior& prior,
            double prior_weight, const StereoCamera& camera, int max_iterations, double soft_chi2,
            Eigen::Isometry3d& T, Matrix6d* information) {
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    Matrix6d H = prior_weight * prior.information;
    Vector6d g = prior_weight * prior.information * PriorStep(prior, T);
    const Eigen::Matrix3d R = T.linear().transpose();
    const Eigen::Vector3d t = T.translation();
    for (const int i : used) {
      Eigen::Vector3d r;
      Matrix36 J;
      if (!Residual(constraints[static_cast<std::size_t>(i)], R, t, camera, r, &J)) continue;
      const double weight = soft_chi2 > 0.0 ? 1.0 / (1.0 + r.squaredNorm() / soft_chi2) : 1.0;
      H.noalias() += weight * J.transpose() * J;
      g.noalias() += weight * J.transpose() * r;
    }
    H.diagonal().array() += 1e-9 * H.trace();
    const auto step = SolvePositive(H, -g);
    if (!step || !step->allFinite()) return false;
    T = Perturb(T, *step);
    if (information) *information = H;
    if (step->norm() < 1e-7) break;
  }
  return true;
}

}  // namespace

Eigen::Matrix3d Whitening(const StereoMeasurement& m, const Eigen::Vector3d& uvd_by_inverse_depth,
                          double inverse_depth_sigma) {
  constexpr double kNotMeasuredPx = 1e4;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>() = m.covariance_uv;
  const double sigma_d = m.has_disparity ? m.sigma_d : kNotMeasuredPx;
  covariance(2, 2) = sigma_d * sigma_d;
  const Eigen::Vector3d spread = uvd_by_inverse_depth * inverse_depth_sigma;
  covariance += spread * spread.transpose();
  // covariance = L L^T, so L^-1 whitens.
  const Eigen::Matrix3d L = covariance.llt().matrixL();
  return L.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
}

PoseSolution SolvePose(const std::vector<PoseConstraint>& constraints, const PosePrior& prior,
                       const StereoCamera& camera, std::uint32_t seed) {
  constexpr int kMaxSamples = 100;
  constexpr double kConfidence = 0.999;
  const int n = static_cast<int>(constraints.size());
  PoseSolution best;
  best.T_world_left = prior.T_world_left;
  best.inlier.assign(constraints.size(), false);
  best.chi2.assign(constraints.size(), kMaxChi2);
  if (n < 4) return best;

  std::vector<int> all(constraints.size());
  for (int i = 0; i < n; ++i) all[static_cast<std::size_t>(i)] = i;

  // First the prior itself and what all points make of it, then samples of three.
  double worst_cost = 0.0;
  for (const PoseConstraint& c : constraints) worst_cost += c.trust * kMaxChi2;
  double best_cost = Cost(constraints, prior.T_world_left, camera);
  const auto Try = [&](const Eigen::Isometry3d& T) {
    const double cost = Cost(constraints, T, camera);
    if (cost < best_cost) {
      best_cost = cost;
      best.T_world_left = T;
    }
  };
  Eigen::Isometry3d T = prior.T_world_left;
  if (Refine(constraints, all, prior, 1.0, camera, 6, kSoftChi2, T, nullptr)) Try(T);

  std::mt19937 random(seed);
  int num_samples = kMaxSamples;
  for (int sample = 0; sample < num_samples; ++sample) {
    std::array<int, 3> chosen{};
    for (int k = 0; k < 3; ++k) {
      do chosen[static_cast<std::size_t>(k)] = static_cast<int>(random() % static_cast<std::uint32_t>(n));
      while (std::find(chosen.begin(), chosen.begin() + k, chosen[static_cast<std::size_t>(k)]) !=
             chosen.begin() + k);
    }
    T = best.T_world_left;
    if (Refine(constraints, chosen, prior, 1e-3, camera, 5, 0.0, T, nullptr)) Try(T);
    const double good = std::clamp(1.0 - best_cost / worst_cost, 0.01, 0.99);
    num_samples = std::min(
        kMaxSamples, static_cast<int>(std::log(1.0 - kConfidence) / std::log(1.0 - good * good * good)) + 1);
  }

  // All that agree, twice: the second set is chosen by the better pose.
  for (int round = 0; round < 2; ++round) {
    const Eigen::Matrix3d R = best.T_world_left.linear().transpose();
    std::vector<int> used;
    for (int i = 0; i < n; ++i) {
      Eigen::Vector3d r;
      if (Residual(constraints[static_cast<std::size_t>(i)], R, best.T_world_left.translation(), camera, r,
                   nullptr) &&
          r.squaredNorm() < kMaxChi2)
        used.push_back(i);
    }
    if (used.size() < 4) return best;
    Refine(constraints, used, prior, 1.0, camera, 6, kSoftChi2, best.T_world_left, &best.information);
  }

  const Eigen::Matrix3d R = best.T_world_left.linear().transpose();
  double chi2 = 0.0;
  double square_px = 0.0;
  int components = 0;
  for (int i = 0; i < n; ++i) {
    const PoseConstraint& c = constraints[static_cast<std::size_t>(i)];
    Eigen::Vector3d r;
    if (!Residual(c, R, best.T_world_left.translation(), camera, r, nullptr)) continue;
    best.chi2[static_cast<std::size_t>(i)] = r.squaredNorm();
    if (r.squaredNorm() >= kMaxChi2) continue;
    best.inlier[static_cast<std::size_t>(i)] = true;
    ++best.num_inliers;
    chi2 += r.squaredNorm();
    components += c.whitening(2, 2) > 1e-3 ? 3 : 2;
    const Eigen::Vector3d q = R * (c.point_world - c.inverse_depth * best.T_world_left.translation());
    square_px += std::pow(camera.fx * q.x() / q.z() + camera.cx - c.uvd.x(), 2) +
                 std::pow(camera.fy * q.y() / q.z() + camera.cy - c.uvd.y(), 2);
  }
  if (best.num_inliers > 0) {
    best.rms_px = std::sqrt(square_px / (2.0 * best.num_inliers));
    best.mean_chi2 = chi2 / components;
  }
  return best;
}

}  // namespace terrace
