// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "core/sensor_frame.h"
#include "daemon/live_config.h"

namespace terrace {

/// Lets only rising times through, as long as they are those of one clock. A time stamp far ahead, or more
/// than a second back, is believed only when the next one agrees: one wild stamp must not shut out all that
/// follow, nor must a clock that was set.
class RisingTimes {
 public:
  explicit RisingTimes(std::chrono::nanoseconds max_jump) : max_jump_(max_jump) {}

  /// True when an item with this time can be used.
  /// @param silence  since the last one arrived: a time stamp that is ahead by as much is no jump
  bool Accept(Timestamp t, std::chrono::nanoseconds silence = {});
  /// By how much the clock was set with the last time that was accepted; zero: it was not.
  std::chrono::nanoseconds clock_set_by() const { return clock_set_by_; }
  const std::optional<Timestamp>& last() const { return last_; }

 private:
  std::chrono::nanoseconds max_jump_;
  std::optional<Timestamp> last_;
  std::optional<Timestamp> suspect_;
  std::chrono::nanoseconds clock_set_by_{0};
};

/// Puts live images together with the samples that belong to them. A pair waits until the IMU has passed its
/// time, since samples often arrive a little after the images, but not for ever. Other samples are taken as
/// they are there. Knows neither LCM nor clock: the time of arrival is an argument.
class FrameAssembler {
 public:
  using ArrivalTime = std::chrono::steady_clock::time_point;

  explicit FrameAssembler(const LiveConfig& config);

  void Add(const ImuSample& sample, ArrivalTime now);
  void Add(const BodyPrior& prior);
  void Add(StereoPair pair, ArrivalTime now);

  /// The oldest frame, once it is complete or has waited long enough.
  std::optional<SensorFrame> TakeReady(ArrivalTime now);
  /// The oldest frame whether complete or not: for the end.
  std::optional<SensorFrame> TakeAny();

  std::int64_t num_time_jumps() const { return num_time_jumps_; }
  /// By how much the clock of the images was set since this was asked last; zero: it was not.
  std::chrono::nanoseconds TakeClockChange() {
    return std::exchange(clock_change_, std::chrono::nanoseconds(0));
  }
  std::int64_t num_imu_gaps() const { return num_imu_gaps_; }
  /// By how much the newest sample of the IMU was ahead of the newest pair when that came; none where they
  /// may be of one clock.
  std::optional<std::chrono::nanoseconds> imu_clock_ahead() const { return imu_clock_ahead_; }

 private:
  void ForgetOtherClock(Timestamp t);
  void CompareClocks(Timestamp t_pair, ArrivalTime now);

  struct WaitingPair {
    StereoPair pair;
    ArrivalTime arrived;
  };

  bool ImuHasPassed(Timestamp t) const { return last_imu_ && *last_imu_ >= t; }
  bool ImuIsAlive(ArrivalTime now) const;

  const std::chrono::nanoseconds imu_wait_;
  const std::chrono::nanoseconds imu_gap_;
  RisingTimes pair_times_;
  RisingTimes imu_times_;
  RisingTimes attitude_times_;
  RisingTimes leg_times_;
  std::deque<WaitingPair> pairs_;
  std::deque<ImuSample> imu_;
  std::deque<BodyPrior> priors_;
  std::optional<Timestamp> last_imu_;
  std::optional<ArrivalTime> imu_arrived_;
  std::optional<ArrivalTime> pair_arrived_;
  std::optional<std::pair<Timestamp, ArrivalTime>> newest_imu_;  // whether it was taken or not
  std::optional<std::chrono::nanoseconds> imu_clock_ahead_;
  std::optional<Timestamp> last_frame_;
  std::chrono::nanoseconds clock_change_{0};
  std::int64_t num_time_jumps_ = 0;
  std::int64_t num_imu_gaps_ = 0;
};

}  // namespace terrace
