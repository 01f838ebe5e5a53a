// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/row_alignment.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

namespace terrace {
namespace {

// ---- matching

constexpr int kHalf = 8;  // half the window's side

float Sample(const cv::Mat1b& image, double u, double v) {
  const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
  const float a = static_cast<float>(u - u0), b = static_cast<float>(v - v0);
  const float above = image(v0, u0) * (1 - a) + image(v0, u0 + 1) * a;
  const float below = image(v0 + 1, u0) * (1 - a) + image(v0 + 1, u0 + 1) * a;
  return above * (1 - b) + below * b;
}

/// The whole pixel in the right image that resembles the left window most; none when it is not alone or no
/// likeness.
std::optional<cv::Point> Search(const StereoFrame& frame, cv::Point at, const RowMatchConfig& config) {
  constexpr double kMinLikeness = 0.8;
  constexpr double kMaxSecond = 0.95;  // of the best, elsewhere
  const cv::Rect window(at.x - kHalf, at.y - kHalf, 2 * kHalf + 1, 2 * kHalf + 1);
  const cv::Rect image(0, 0, frame.left.cols, frame.left.rows);
  constexpr int kBeyond = 4;  // behind infinity, for what is turned
  const cv::Rect searched =
      image & cv::Rect(window.x - config.max_disparity_px, window.y - config.max_row_error_px,
                       window.width + config.max_disparity_px + kBeyond,
                       window.height + 2 * config.max_row_error_px);
  if ((window & image) != window || searched.width < window.width || searched.height < window.height)
    return std::nullopt;
  cv::Mat1f likeness;
  cv::matchTemplate(frame.right(searched), frame.left(window), likeness, cv::TM_CCOEFF_NORMED);
  double best = 0.0;
  cv::Point place;
  cv::minMaxLoc(likeness, nullptr, &best, nullptr, &place);
  if (best < kMinLikeness) return std::nullopt;
  cv::Mat1f others = likeness.clone();
  constexpr int kNear = 4;
  others(cv::Rect(place.x - kNear, place.y - kNear, 2 * kNear + 1, 2 * kNear + 1) &
         cv::Rect(0, 0, likeness.cols, likeness.rows))
      .setTo(-1.0);
  double second = 0.0;
  cv::minMaxLoc(others, nullptr, &second);
  if (second > kMaxSecond * best) return std::nullopt;
  return cv::Point(searched.x + place.x + kHalf, searched.y + place.y + kHalf);
}

/// Gauss-Newton on the window: a shift, shear and stretch of the rows by the slant of the surface, contrast
/// and brightness.
std::optional<Eigen::Vector2d> Refine(const StereoFrame& frame, cv::Point left, cv::Point right) {
  constexpr int kSteps = 12;
  constexpr double kMaxMove = 2.0;
  constexpr double kSettled = 0.01;
  constexpr double kMaxResidual = 0.35;  // of the window's contrast
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  Vector6 p = Vector6::Zero();  // du, dv, stretch, shear, contrast less one, brightness
  double residual = 0.0, contrast = 0.0, last_move = 1.0;
  for (int step = 0; step < kSteps && last_move > kSettled * 0.1; ++step) {
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Vector6 b = Vector6::Zero();
    residual = contrast = 0.0;
    double sum = 0.0, sum2 = 0.0;
    for (int y = -kHalf; y <= kHalf; ++y) {
      for (int x = -kHalf; x <= kHalf; ++x) {
        const double u = right.x + x + p[0] + p[2] * x + p[3] * y;
        const double v = right.y + y + p[1];
        if (u < 1 || v < 1 || u >= frame.right.cols - 3 || v >= frame.right.rows - 3) return std::nullopt;
        const double grey = frame.left(left.y + y, left.x + x);
        const double there = Sample(frame.right, u, v);
        const double gu = 0.5 * (Sample(frame.right, u + 1, v) - Sample(frame.right, u - 1, v));
        const double gv = 0.5 * (Sample(frame.right, u, v + 1) - Sample(frame.right, u, v - 1));
        const double error = (1.0 + p[4]) * grey + p[5] - there;
        Vector6 J;
        J << gu, gv, gu * x, gu * y, -grey, -1.0;
        A += J * J.transpose();
        b += J * error;
        residual += error * error;
        sum += grey;
        sum2 += grey * grey;
      }
    }
    constexpr double kCount = (2 * kHalf + 1) * (2 * kHalf + 1);
    contrast = sum2 - sum * sum / kCount;
    const Vector6 move = A.ldlt().solve(b);
    if (!move.allFinite()) return std::nullopt;
    p += move;
    last_move = move.head<2>().norm();
    if (p.head<2>().norm() > kMaxMove) return std::nullopt;
  }
  if (last_move > kSettled || residual > kMaxResidual * kMaxResidual * contrast) return std::nullopt;
  return Eigen::Vector2d(right.x + p[0], right.y + p[1]);
}

// ---- estimation

double MedianOf(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// shift [focal lengths], rotation x, y, z [rad], logarithm of the scale.
using Parameters = Eigen::Matrix<double, 5, 1>;

/// Row in the left image less that in the right one, which is put right by the parameters first.
double RowError(const RowMatch& match, const StereoCamera& camera, const Parameters& p) {
  const double scale = std::exp(p[4]);
  const Eigen::Vector3d seen((match.right_px.x() - camera.cx) / (camera.fx * scale),
                             (match.right_px.y() - camera.cy) / (camera.fy * scale) - p[0], 1.0);
  const Eigen::Vector3d turn = p.segment<3>(1);
  const double angle = turn.norm();
  const Eigen::Vector3d ray =
      angle > 1e-12 ? Eigen::Vector3d(Eigen::AngleAxisd(-angle, turn / angle) * seen) : seen;
  return camera.fy * ray.y() / ray.z() + camera.cy - match.left_px.y();
}

std::vector<double> RowErrors(const std::vector<RowMatch>& matches, const StereoCamera& camera,
                              const Parameters& p) {
  std::vector<double> errors;
  for (const RowMatch& match : matches) errors.push_back(RowError(match, camera, p));
  return errors;
}

}  // namespace

std::vector<RowMatch> MatchAcrossRows(const StereoFrame& frame, const RowMatchConfig& config) {
  constexpr double kQuality = 0.01;
  constexpr double kDistancePx = 10.0;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(frame.left, corners, config.max_features, kQuality, kDistancePx);
  std::vector<RowMatch> matches;
  for (const cv::Point2f& corner : corners) {
    const cv::Point at(static_cast<int>(corner.x), static_cast<int>(corner.y));
    const auto found = Search(frame, at, config);
    if (!found) continue;
    if (const auto refined = Refine(frame, at, *found)) matches.push_back({{at.x, at.y}, *refined});
  }
  return matches;
}

RowAlignment EstimateRowAlignment(const std::vector<RowMatch>& matches, const StereoCamera& camera) {
  RowAlignment out;
  out.num_matches = static_cast<int>(matches.size());
  if (out.num_matches < RowAlignment::kFewestMatches) return out;
  Parameters p = Parameters::Zero();
  std::vector<double> sizes = RowErrors(matches, camera, p);
  for (double& size : sizes) size = std::abs(size);
  std::sort(sizes.begin(), sizes.end());
  out.median_px = sizes[sizes.size() / 2];
  out.p95_px = sizes[sizes.size() * 95 / 100];

  // What rows can hardly tell apart stays small: rigs are off by so much.
  const Parameters prior_sigma = (Parameters() << 0.1, 0.01, 0.03, 0.1, 0.1).finished();
  constexpr int kSteps = 30;
  constexpr double kSmallestScalePx = 0.02;
  Eigen::Matrix<double, 5, 5> A;
  double scale_px = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    const std::vector<double> errors = RowErrors(matches, camera, p);
    std::vector<double> off(errors);
    for (double& e : off) e = std::abs(e);
    scale_px = std::max(1.4826 * MedianOf(off), kSmallestScalePx);
    A = Eigen::Matrix<double, 5, 5>::Zero();
    Parameters b = Parameters::Zero();
    for (std::size_t i = 0; i < matches.size(); ++i) {
      Parameters J;
      for (int k = 0; k < 5; ++k) {
        constexpr double kTiny = 1e-6;
        Parameters moved = p;
        moved[k] += kTiny;
        J[k] = (RowError(matches[i], camera, moved) - errors[i]) / kTiny;
      }
      // Cauchy's weight: wrong matches count for little.
      const double weight = 1.0 / (scale_px * scale_px + 0.25 * errors[i] * errors[i]);
      A += weight * J * J.transpose();
      b -= weight * J * errors[i];
    }
    for (int k = 0; k < 5; ++k) {
      const double information = 1.0 / (prior_sigma[k] * prior_sigma[k]);
      A(k, k) += information;
      b[k] -= information * p[k];
    }
    const Parameters move = A.ldlt().solve(b);
    p += move;
    if (move.norm() < 1e-9) break;
  }
  const Eigen::Matrix<double, 5, 5> covariance = A.inverse();
  std::vector<double> left_over = RowErrors(matches, camera, p);
  for (double& e : left_over) e = std::abs(e);
  out.left_over_px = MedianOf(left_over);
  // Sub-pixel places of all points are off alike by some hundredths of a pixel, however many there are.
  constexpr double kBiasPx = 0.03;
  double radius2_px2 = 0.0;  // mean square distance from the middle
  for (const RowMatch& match : matches)
    radius2_px2 += (match.left_px - Eigen::Vector2d(camera.cx, camera.cy)).squaredNorm() /
                   static_cast<double>(matches.size());
  const double bias_rad = kBiasPx / std::sqrt(std::max(radius2_px2, 1.0));
  // A turn about x moves the middle like a shift.
  out.row_shift_px = camera.fy * (p[0] - p[1]);
  out.row_shift_sigma_px = std::hypot(
      kBiasPx,
      camera.fy * std::sqrt(std::max(covariance(0, 0) + covariance(1, 1) - 2.0 * covariance(0, 1), 0.0)));
  out.roll_rad = p[3];
  out.roll_sigma_rad = std::hypot(bias_rad, std::sqrt(covariance(3, 3)));
  out.focal_ratio = std::exp(p[4]);
  out.focal_ratio_sigma = out.focal_ratio * std::hypot(bias_rad, std::sqrt(covariance(4, 4)));
  return out;
}

}  // namespace terrace
