// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pair_delay.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <opencv2/video/tracking.hpp>

#include "core/statistics.h"

namespace terrace {
namespace {

std::vector<cv::Point2f> Followed(const cv::Mat1b& from, const cv::Mat1b& to,
                                  const std::vector<cv::Point2f>& points, std::vector<unsigned char>* found) {
  std::vector<cv::Point2f> there;
  std::vector<float> ignored;
  cv::calcOpticalFlowPyrLK(from, to, points, there, *found, ignored);
  // Back again: what does not return was something else.
  std::vector<cv::Point2f> back;
  std::vector<unsigned char> found_back;
  cv::calcOpticalFlowPyrLK(to, from, there, back, found_back, ignored);
  constexpr double kMaxReturnPx = 0.3;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!found_back[i] || cv::norm(back[i] - points[i]) > kMaxReturnPx) (*found)[i] = 0;
  return there;
}

}  // namespace

std::vector<MovingRowMatch> FollowMatches(const std::vector<RowMatch>& matches, const StereoFrame& before,
                                          const StereoFrame& at, const StereoFrame& after) {
  const double duration_s = Seconds(after.t_capture - before.t_capture);
  if (matches.empty() || duration_s <= 0.0) return {};
  std::vector<cv::Point2f> points;
  for (const RowMatch& match : matches)
    points.emplace_back(static_cast<float>(match.left_px.x()), static_cast<float>(match.left_px.y()));
  std::vector<unsigned char> in_before, in_after;
  const std::vector<cv::Point2f> earlier = Followed(at.left, before.left, points, &in_before);
  const std::vector<cv::Point2f> later = Followed(at.left, after.left, points, &in_after);
  std::vector<MovingRowMatch> moving;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (in_before[i] && in_after[i]) moving.push_back({matches[i], (later[i].y - earlier[i].y) / duration_s});
  }
  return moving;
}

bool PairDelay::told() const {
  // A millisecond at this speed is a fiftieth of a pixel, which the rows of hundreds of points tell.
  constexpr double kSlowestPxS = 20.0;
  constexpr double kLargestSigmaS = 1e-3;
  return num_matches >= RowAlignment::kFewestMatches && row_speed_px_s >= kSlowestPxS &&
         fit_sigma_s <= kLargestSigmaS;
}

PairDelay EstimateDelay(const std::vector<MovingRowMatch>& matches, const StereoCamera& camera) {
  PairDelay out;
  out.num_matches = static_cast<int>(matches.size());
  if (out.num_matches < RowAlignment::kFewestMatches) return out;
  const auto n = static_cast<Eigen::Index>(matches.size());
  // What stays: shift, roll, stretch, turn about the vertical, and a baseline that leans up or forward, in
  // which the rows of what is near are off as they are while the camera drives ahead. Last what moves with
  // the image.
  constexpr int kUnknowns = 7;
  Eigen::MatrixXd A(n, kUnknowns);
  Eigen::VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const MovingRowMatch& m = matches[static_cast<std::size_t>(i)];
    const double right = (m.match.left_px.x() - camera.cx) / camera.fx;
    const double down = (m.match.left_px.y() - camera.cy) / camera.fy;
    const double near = (m.match.left_px.x() - m.match.right_px.x()) / camera.fx;
    A.row(i) << 1.0, right, down, right * down, near, near * down, m.row_velocity_px_s;
    b[i] = m.match.right_px.y() - m.match.left_px.y();
    out.row_speed_px_s += std::abs(m.row_velocity_px_s) / static_cast<double>(n);
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(n);
  Eigen::VectorXd x;
  Eigen::MatrixXd information;
  constexpr int kSteps = 20;
  constexpr double kSmallestScalePx = 0.02;
  for (int step = 0; step < kSteps; ++step) {
    information = A.transpose() * weights.asDiagonal() * A;
    // A wall that faces the camera tells nothing of some: they stay small.
    information.diagonal().array() += 1e-6 * static_cast<double>(n);
    x = information.ldlt().solve(A.transpose() * weights.asDiagonal() * b);
    const Eigen::VectorXd off = (A * x - b).cwiseAbs();
    const double scale_px = std::max(kSmallestScalePx, 1.4826 * Quantile({off.data(), off.data() + n}, 0.5));
    // Cauchy's weight: wrong matches count for little.
    weights = (scale_px * scale_px + 0.25 * off.array().square()).inverse().matrix();
  }
  constexpr int kDelay = kUnknowns - 1;
  out.delay_s = x[kDelay];
  // The mean velocity over two frames is up to a tenth below that in the middle where the body sways as in
  // walking.
  constexpr double kVelocityError = 0.1;
  out.fit_sigma_s = std::sqrt(std::max(0.0, information.inverse()(kDelay, kDelay)));
  out.sigma_s = std::hypot(out.fit_sigma_s, kVelocityError * out.delay_s);
  return out;
}

}  // namespace terrace
