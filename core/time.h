// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>

namespace terrace {

/// A moment, in nanoseconds since the Unix epoch. Name variables by event: `t_capture`, `t_published`.
struct Timestamp {
  std::int64_t ns = 0;

  static constexpr Timestamp FromMicroseconds(std::int64_t utime) { return {utime * 1000}; }
  /// Microseconds since the epoch, as messages carry them; rounds towards the past.
  constexpr std::int64_t utime() const { return ns >= 0 ? ns / 1000 : -((-ns + 999) / 1000); }
  constexpr double seconds() const { return static_cast<double>(ns) * 1e-9; }

  friend constexpr auto operator<=>(Timestamp, Timestamp) = default;
  friend constexpr std::chrono::nanoseconds operator-(Timestamp a, Timestamp b) {
    return std::chrono::nanoseconds(a.ns - b.ns);
  }
  friend constexpr Timestamp operator+(Timestamp t, std::chrono::nanoseconds d) { return {t.ns + d.count()}; }
  friend constexpr Timestamp operator-(Timestamp t, std::chrono::nanoseconds d) { return {t.ns - d.count()}; }
};

/// A duration in seconds, for arithmetic with velocities and rates.
constexpr double Seconds(std::chrono::nanoseconds d) { return static_cast<double>(d.count()) * 1e-9; }

/// Counts the frames that entered the pipeline, from 0. What feedback and schedules count in.
using FrameId = std::int64_t;

}  // namespace terrace
