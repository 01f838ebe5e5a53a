// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/imu_watch.h"

#include <algorithm>

namespace terrace {
namespace {

constexpr int kStands = 20;  // samples that say the same; drivers repeat a few
constexpr double kStandsFor_s = 0.1;
constexpr double kSilent_s = 0.5;
constexpr double kStretch_s = 1.0;
constexpr int kEnoughOfAStretch = 50;  // samples

}  // namespace

void ImuWatch::Extreme::Add(double value, bool first) {
  if (first) *this = {};
  const bool new_least = first || value < least, new_most = first || value > most;
  if (new_least) least = value, num_least = 0;
  if (new_most) most = value, num_most = 0;
  num_least += value == least;
  num_most += value == most;
  if (new_least || new_most) {
    run = 1;
  } else {
    run = value == least || value == most ? run + 1 : 0;
  }
  longest_run = std::max(longest_run, run);
}

bool ImuWatch::Extreme::IsClipped(double least_range, int num_samples) const {
  constexpr double kShare = 0.05;
  constexpr int kRun = 8;
  // At rest, coarse steps repeat themselves; that says nothing.
  return most - least > least_range && longest_run >= kRun &&
         std::max(num_least, num_most) > kShare * num_samples;
}

std::optional<std::string> ImuWatch::Read(const std::vector<ImuSample>& samples) {
  for (const ImuSample& sample : samples) {
    Compare(sample);
    const bool first = num_in_stretch_ == 0;
    if (first) t_stretch_ = sample.t;
    for (int i = 0; i < 3; ++i) {
      extremes_[static_cast<std::size_t>(i)].Add(sample.gyro[i], first);
      extremes_[static_cast<std::size_t>(i) + 3].Add(sample.accel[i], first);
    }
    ++num_in_stretch_;
    if (num_in_stretch_ < kEnoughOfAStretch || Seconds(sample.t - t_stretch_) < kStretch_s) continue;
    if (const auto problem = Clipped()) return problem;
    num_in_stretch_ = 0;
  }
  return std::nullopt;
}

void ImuWatch::Compare(const ImuSample& sample) {
  const bool same = last_ && last_->gyro == sample.gyro && last_->accel == sample.accel;
  if (!same) num_same_ = 0, t_same_ = sample.t;
  num_same_ += same;
  last_ = sample;
}

bool ImuWatch::stands() const {
  return last_ && num_same_ >= kStands && Seconds(last_->t - t_same_) >= kStandsFor_s;
}

std::optional<std::string> ImuWatch::Clipped() {
  constexpr double kGyroRange = 0.5, kAccelRange = 2.0;  // rad/s, m/s^2: what moves
  for (std::size_t i = 0; i < extremes_.size(); ++i) {
    if (!extremes_[i].IsClipped(i < 3 ? kGyroRange : kAccelRange, num_in_stretch_)) continue;
    const Extreme& e = extremes_[i];
    const double at = e.num_most > e.num_least ? e.most : e.least;
    return std::string(i < 3 ? "the gyroscope" : "the accelerometer") + " of the IMU shows no more than " +
           std::to_string(at) + (i < 3 ? " rad/s" : " m/s^2") + ": its range is too small for this motion";
  }
  return std::nullopt;
}

bool ImuWatch::HasFallenSilent(Timestamp t_capture) {
  if (!last_) return false;
  const bool silent = Seconds(t_capture - last_->t) > kSilent_s;
  const bool news = silent && !silent_;
  silent_ = silent;
  return news;
}

}  // namespace terrace
