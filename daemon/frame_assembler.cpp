// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/frame_assembler.h"

#include <algorithm>
#include <utility>

namespace terrace {
namespace {

// A quarter of a minute at 1 kHz: what is kept of samples when no images come.
constexpr std::size_t kMaxSamples = 16384;
constexpr std::size_t kMaxWaitingPairs = 8;
// An IMU that has been silent for this long is not waited for.
constexpr std::chrono::milliseconds kImuSilent(500);

std::chrono::nanoseconds FromSeconds(double seconds) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

template <typename Sample>
std::vector<Sample> TakeUpTo(Timestamp t, std::deque<Sample>* samples) {
  const auto end = std::find_if(samples->begin(), samples->end(), [t](const Sample& s) { return s.t > t; });
  std::vector<Sample> taken(std::make_move_iterator(samples->begin()), std::make_move_iterator(end));
  samples->erase(samples->begin(), end);
  return taken;
}

}  // namespace

bool RisingTimes::Accept(Timestamp t, std::chrono::nanoseconds silence) {
  constexpr std::chrono::seconds kOvertakes(1);  // messages of one clock overtake one another by less
  const bool back = last_ && *last_ - t > kOvertakes;
  if (last_ && t <= *last_ && !back) return false;
  const bool jumps = back || (last_ && t - *last_ > max_jump_ + silence);
  const bool confirmed = suspect_ && t > *suspect_ && t - *suspect_ <= max_jump_;
  if (jumps && !confirmed) {
    suspect_ = t;
    return false;
  }
  suspect_.reset();
  clock_set_by_ = jumps ? t - *last_ : std::chrono::nanoseconds(0);
  last_ = t;
  return true;
}

FrameAssembler::FrameAssembler(const LiveConfig& config)
    : imu_wait_(FromSeconds(1e-3 * config.imu_wait_ms)),
      imu_gap_(FromSeconds(1e-3 * config.imu_gap_ms)),
      pair_times_(FromSeconds(config.max_time_jump_s)),
      imu_times_(FromSeconds(config.max_time_jump_s)),
      attitude_times_(FromSeconds(config.max_time_jump_s)),
      leg_times_(FromSeconds(config.max_time_jump_s)) {}

void FrameAssembler::Add(const ImuSample& sample, ArrivalTime now) {
  newest_imu_ = {sample.t, now};
  // What belongs to a frame that is out already has come too late.
  if (!imu_times_.Accept(sample.t, now - imu_arrived_.value_or(now)) ||
      (last_frame_ && sample.t <= *last_frame_)) {
    ++num_imu_gaps_;
    return;
  }
  if (last_imu_ && sample.t - *last_imu_ > imu_gap_) ++num_imu_gaps_;
  last_imu_ = sample.t;
  imu_arrived_ = now;
  imu_.push_back(sample);
  if (imu_.size() > kMaxSamples) imu_.pop_front();
}

void FrameAssembler::Add(const BodyPrior& prior) {
  RisingTimes& times = prior.kind == PriorKind::kAttitude ? attitude_times_ : leg_times_;
  if (!times.Accept(prior.t) || (last_frame_ && prior.t <= *last_frame_)) return;
  // The two kinds come from two programs, whose messages may overtake one another.
  const auto place = std::upper_bound(priors_.begin(), priors_.end(), prior.t,
                                      [](Timestamp t, const BodyPrior& other) { return t < other.t; });
  priors_.insert(place, prior);
  if (priors_.size() > kMaxSamples) priors_.pop_front();
}

void FrameAssembler::Add(StereoPair pair, ArrivalTime now) {
  if (!pair_times_.Accept(pair.t_capture, now - pair_arrived_.value_or(now))) {
    ++num_time_jumps_;
    return;
  }
  pair_arrived_ = now;
  if (pair_times_.clock_set_by().count() != 0) {
    clock_change_ = pair_times_.clock_set_by();
    ForgetOtherClock(pair.t_capture);
  }
  CompareClocks(pair.t_capture, now);
  pairs_.push_back({std::move(pair), now});
}

/// Samples of another clock are never those of a frame.
void FrameAssembler::CompareClocks(Timestamp t_pair, ArrivalTime now) {
  constexpr std::chrono::seconds kLate(2);  // images may be on their way for some time
  imu_clock_ahead_.reset();
  if (!newest_imu_ || now - newest_imu_->second > kImuSilent) return;
  const std::chrono::nanoseconds ahead = newest_imu_->first - t_pair;
  if (ahead > kLate || ahead < -kLate) imu_clock_ahead_ = ahead;
}

/// Samples and pairs of the clock of before would be taken for older or newer than they are.
void FrameAssembler::ForgetOtherClock(Timestamp t) {
  constexpr std::chrono::seconds kNear(1);
  const auto is_other = [&](const auto& sample) { return sample.t > t + kNear || sample.t < t - kNear; };
  std::erase_if(imu_, is_other);
  std::erase_if(priors_, is_other);
  last_frame_.reset();
  last_imu_.reset();
  if (!imu_.empty()) last_imu_ = imu_.back().t;
}

bool FrameAssembler::ImuIsAlive(ArrivalTime now) const {
  return imu_arrived_ && now - *imu_arrived_ < kImuSilent;
}

std::optional<SensorFrame> FrameAssembler::TakeReady(ArrivalTime now) {
  if (pairs_.empty()) return std::nullopt;
  const WaitingPair& first = pairs_.front();
  if (!ImuHasPassed(first.pair.t_capture) && ImuIsAlive(now)) {
    const bool in_time = now - first.arrived < imu_wait_ && pairs_.size() <= kMaxWaitingPairs;
    if (in_time) return std::nullopt;
    ++num_imu_gaps_;
  }
  return TakeAny();
}

std::optional<SensorFrame> FrameAssembler::TakeAny() {
  if (pairs_.empty()) return std::nullopt;
  SensorFrame frame;
  frame.pair = std::move(pairs_.front().pair);
  pairs_.pop_front();
  last_frame_ = frame.pair.t_capture;
  frame.samples.imu = TakeUpTo(*last_frame_, &imu_);
  frame.samples.priors = TakeUpTo(*last_frame_, &priors_);
  return frame;
}

}  // namespace terrace
