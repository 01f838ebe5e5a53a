// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/delay_monitor.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "core/print.h"

namespace terrace {
namespace {

constexpr double kNominal_px = 0.1;
constexpr double kLeastScatter_px = 0.02;
/// One landmark's errors resemble its neighbours', as in the pose's covariance.
constexpr double kAlike = 4.5;
constexpr double kKeep = 0.9;  // from frame to frame
constexpr std::size_t kFewest = 15;
/// Frames that are farther apart say nothing of the speed in between.
constexpr double kLongest_s = 0.5;

/// What is known before anything is seen: images of a pair are a few frames apart at most, calibrations are
/// off by some rows, by two degrees, and their baseline leans by a fiftieth of its length.
constexpr double kPriorDelay_s = 0.2, kPriorShift_px = 3.0, kPriorAngle_rad = 0.03, kPriorLean = 0.02;

/// As far as disparities of a robot in a hurry bear it: at 1 rad/s, 3 ms are a pixel of most lenses.
constexpr double kOff_s = 0.003;
constexpr double kDelayedSigmas = 6.0;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

DelayMonitor::DelayMonitor(const StereoCamera& camera)
    : camera_(camera), scatter_px_(kNominal_px), sigma_s_(kPriorDelay_s) {
  const double angle_px = kPriorAngle_rad * camera.fx, lean_px = kPriorLean * camera.fx;
  Unknowns sigmas;
  sigmas << kPriorShift_px, angle_px, angle_px, angle_px, lean_px, lean_px, kPriorDelay_s;
  prior_.diagonal() = sigmas.array().square().inverse();
}

std::string DelayMonitor::Reason() const {
  return Printed(
      "the two images are not of one moment: the %s camera is %.0f ms late, by how its rows follow the "
      "motion; trigger both at once",
      delay_s_ > 0.0 ? "right" : "left", 1e3 * std::abs(delay_s_));
}

std::optional<std::string> DelayMonitor::Update(const Window& window, const std::vector<Match>& matches,
                                                Timestamp t_capture) {
  Sighting now{t_capture, {}};
  for (const Match& match : matches) {
    Place place{match.measurement.uvd, match.found_in_right, match.vertical_px};
    // Of one that lies too high or too low no disparity was taken.
    if (!match.measurement.has_disparity) place.uvd_px.z() = match.predicted.uvd.z();
    now.places.push_back({window.landmarks[static_cast<std::size_t>(match.landmark)].id, place});
  }
  std::stable_sort(now.places.begin(), now.places.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const std::vector<Row> rows = RowsBetween(now);
  before_ = std::move(middle_);
  middle_ = std::move(now);
  if (rows.size() < kFewest) return std::nullopt;
  Learn(rows);
  // It takes evidence to be off, and evidence to be right again: not to know is neither.
  const double off = std::abs(delay_s_);
  const bool was_off = is_off_;
  is_off_ = is_off_ ? off + 2.0 * sigma_s_ > kOff_s : off > kOff_s && off > kDelayedSigmas * sigma_s_;
  was_right_ = was_right_ || (!is_off_ && off + 2.0 * sigma_s_ < kOff_s);
  if (was_off == is_off_) return std::nullopt;
  return is_off_ ? Reason() : "the two images are of one moment again";
}

std::vector<DelayMonitor::Row> DelayMonitor::RowsBetween(const Sighting& after) const {
  std::vector<Row> rows;
  if (!before_ || !middle_) return rows;
  const double dt_s = Seconds(after.t_capture - before_->t_capture);
  if (!(before_->t_capture < middle_->t_capture && middle_->t_capture < after.t_capture) || dt_s > kLongest_s)
    return rows;
  auto earlier = before_->places.begin();
  auto later = after.places.begin();
  for (const auto& [id, place] : middle_->places) {
    while (earlier != before_->places.end() && earlier->first < id) ++earlier;
    while (later != after.places.end() && later->first < id) ++later;
    if (earlier == before_->places.end() || later == after.places.end()) break;
    if (!place.in_right || earlier->first != id || later->first != id) continue;
    // Taken from both sides of the frame, so that its own errors are not in it.
    const double down_px_s = (later->second.uvd_px.y() - earlier->second.uvd_px.y()) / dt_s;
    const double right = (place.uvd_px.x() - camera_.cx) / camera_.fx,
                 down = (place.uvd_px.y() - camera_.cy) / camera_.fy, near = place.uvd_px.z() / camera_.fx;
    Row row;
    row.influence << 1.0, right, down, right * down, near, near * down, -down_px_s;
    row.lower_px = place.lower_px;
    rows.push_back(row);
  }
  return rows;
}

/// Least squares over the frames so far, which fade, and this one, in which wrong matches count for little.
void DelayMonitor::Learn(const std::vector<Row>& rows) {
  constexpr int kRounds = 6;
  std::vector<double> weights(rows.size(), 1.0), off_px(rows.size());
  Information information;
  Unknowns weighted, found;
  double scatter_px = kNominal_px;
  for (int round = 0; round < kRounds; ++round) {
    information = kKeep * information_;
    weighted = kKeep * weighted_;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double weight = weights[i] / (kNominal_px * kNominal_px);
      information.noalias() += weight * rows[i].influence * rows[i].influence.transpose();
      weighted += weight * rows[i].lower_px * rows[i].influence;
    }
    found = (information + prior_).ldlt().solve(weighted);
    for (std::size_t i = 0; i < rows.size(); ++i)
      off_px[i] = std::abs(rows[i].lower_px - rows[i].influence.dot(found));
    constexpr double kSigmaOfMedian = 1.4826;  // of a normal distribution
    scatter_px = std::max(kLeastScatter_px, kSigmaOfMedian * Median(off_px));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double sigmas = off_px[i] / (2.0 * scatter_px);
      weights[i] = 1.0 / (1.0 + sigmas * sigmas);  // Cauchy's
    }
  }
  if (!found.allFinite()) return;
  information_ = information;
  weighted_ = weighted;
  scatter_px_ = kKeep * scatter_px_ + (1.0 - kKeep) * scatter_px;
  const double noise = std::max(scatter_px, scatter_px_) / kNominal_px;
  const Information certain = information_ / (noise * noise * kAlike) + prior_;
  delay_s_ = found[kNumUnknowns - 1];
  sigma_s_ = std::sqrt(std::max(0.0, certain.inverse()(kNumUnknowns - 1, kNumUnknowns - 1)));
}

}  // namespace terrace
