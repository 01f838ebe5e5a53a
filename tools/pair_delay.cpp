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

/// Moves points on by a frame, and forgets those that are not found.
struct Trail {
  std::vector<cv::Point2f> points;
  std::vector<unsigned char> found;

  void Follow(const cv::Mat1b& from, const cv::Mat1b& to) {
    std::vector<unsigned char> found_now;
    points = Followed(from, to, points, &found_now);
    for (std::size_t i = 0; i < found.size(); ++i) found[i] = found[i] && found_now[i] ? 1 : 0;
  }
};

constexpr int kMiddle = MovingRowMatch::kNumFrames / 2;

/// What stays: shift, roll, stretch, turn about the vertical, and a baseline that leans up or forward, in
/// which the rows of what is near are off as they are while the camera drives ahead. Last what moves with
/// the image.
constexpr int kUnknowns = 7;
constexpr int kDelay = kUnknowns - 1;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

/// What a point's row is off by, for each unknown.
/// @param row_px_s  how fast it moves on the average while the right camera is late
Unknowns Influences(const RowMatch& match, const StereoCamera& camera, double row_px_s) {
  const double right = (match.left_px.x() - camera.cx) / camera.fx;
  const double down = (match.left_px.y() - camera.cy) / camera.fy;
  const double near = (match.left_px.x() - match.right_px.x()) / camera.fx;
  Unknowns J;
  J << 1.0, right, down, right * down, near, near * down, row_px_s;
  return J;
}

/// Mean speed from a match until so much later.
double SpeedUntil(const MovingRowMatch& match, double t_s, int degree) {
  constexpr double kLeastS = 1e-4;  // a curve is straight within
  const double until_s = std::abs(t_s) < kLeastS ? kLeastS : t_s;
  return match.RowAfter(until_s, degree) / until_s;
}

}  // namespace

double MovingRowMatch::RowAfter(double t, int degree) const {
  // Lagrange's polynomial.
  const int first = kMiddle - degree / 2, last = kMiddle + degree / 2;
  double row = 0.0;
  for (int i = first; i <= last; ++i) {
    double share = 1.0;
    for (int k = first; k <= last; ++k) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(k);
      if (k != i) share *= (t - t_s[b]) / (t_s[a] - t_s[b]);
    }
    row += share * row_px[static_cast<std::size_t>(i)];
  }
  return row;
}

std::vector<MovingRowMatch> FollowMatches(
    const std::vector<RowMatch>& matches,
    const std::array<const StereoFrame*, MovingRowMatch::kNumFrames>& frames) {
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (!(frames[i]->t_capture > frames[i - 1]->t_capture)) return {};
  if (matches.empty()) return {};
  Trail start;
  for (const RowMatch& match : matches)
    start.points.emplace_back(static_cast<float>(match.left_px.x()), static_cast<float>(match.left_px.y()));
  start.found.assign(matches.size(), 1);
  std::array<Trail, MovingRowMatch::kNumFrames> trails;
  trails[kMiddle] = start;
  for (int i = kMiddle; i > 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    trails[at - 1] = trails[at];
    trails[at - 1].Follow(frames[at]->left, frames[at - 1]->left);
  }
  for (std::size_t at = kMiddle; at + 1 < frames.size(); ++at) {
    trails[at + 1] = trails[at];
    trails[at + 1].Follow(frames[at]->left, frames[at + 1]->left);
  }
  std::vector<MovingRowMatch> moving;
  for (std::size_t k = 0; k < matches.size(); ++k) {
    if (!trails.front().found[k] || !trails.back().found[k]) continue;
    MovingRowMatch m;
    m.match = matches[k];
    for (std::size_t i = 0; i < frames.size(); ++i) {
      m.t_s[i] = Seconds(frames[i]->t_capture - frames[kMiddle]->t_capture);
      m.row_px[i] = trails[i].points[k].y - matches[k].left_px.y();
    }
    moving.push_back(m);
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
  Eigen::MatrixXd A(n, kUnknowns);
  Eigen::VectorXd b(n), rough_px_s(n);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(n);
  Unknowns x = Unknowns::Zero();
  Eigen::Matrix<double, kUnknowns, kUnknowns> information;
  constexpr int kSteps = 20;
  constexpr double kSmallestScalePx = 0.02;
  for (int step = 0; step < kSteps; ++step) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const MovingRowMatch& m = matches[static_cast<std::size_t>(i)];
      // Not farther than it was followed.
      const double until_s = std::clamp(x[kDelay], m.t_s.front(), m.t_s.back());
      A.row(i) = Influences(m.match, camera, SpeedUntil(m, until_s, MovingRowMatch::kNumFrames - 1));
      rough_px_s[i] = SpeedUntil(m, until_s, 2);
      b[i] = m.match.right_px.y() - m.match.left_px.y();
    }
    information = A.transpose() * weights.asDiagonal() * A;
    // A wall that faces the camera tells nothing of some: they stay small.
    information.diagonal().array() += 1e-6 * static_cast<double>(n);
    x = information.ldlt().solve(A.transpose() * weights.asDiagonal() * b);
    const Eigen::VectorXd off = (A * x - b).cwiseAbs();
    const double scale_px = std::max(kSmallestScalePx, 1.4826 * Quantile({off.data(), off.data() + n}, 0.5));
    // What two curves through the same rows do not agree on is not known between frames.
    const Eigen::VectorXd unsure_px = (x[kDelay] * (A.col(kDelay) - rough_px_s)).cwiseAbs();
    // Cauchy's weight: wrong matches count for little.
    weights =
        (scale_px * scale_px + 0.25 * off.array().square() + unsure_px.array().square()).inverse().matrix();
  }
  out.row_speed_px_s = A.col(kDelay).cwiseAbs().mean();
  out.delay_s = x[kDelay];
  out.fit_sigma_s = std::sqrt(std::max(0.0, information.inverse()(kDelay, kDelay)));
  // By how much the coarser curve would find another delay; the finer one is better by far, but as blind for
  // what is faster than the frames.
  const Eigen::ArrayXd speed = A.col(kDelay).array(), w = weights.array();
  const double curves_differ =
      (w * speed * (speed - rough_px_s.array())).sum() / std::max((w * speed.square()).sum(), 1e-12);
  constexpr double kOfThatStays = 0.5;
  // Sub-pixel places of all points are off alike.
  constexpr double kBiasPx = 0.01;
  out.sigma_s = std::hypot(out.fit_sigma_s, kOfThatStays * curves_differ * out.delay_s,
                           kBiasPx / std::max(out.row_speed_px_s, 1e-6));
  return out;
}

std::vector<RowMatch> WithoutDelay(const std::vector<MovingRowMatch>& matches, double delay_s) {
  std::vector<RowMatch> out;
  for (const MovingRowMatch& m : matches) {
    out.push_back(m.match);
    out.back().right_px.y() -= m.RowAfter(std::clamp(delay_s, m.t_s.front(), m.t_s.back()));
  }
  return out;
}

}  // namespace terrace
