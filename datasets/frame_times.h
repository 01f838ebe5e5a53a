// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/sensor_frame.h"
#include "core/time.h"

namespace terrace {

/// Where a clock was set back in a recording: from this row on. Two rows that agree with each other make a
/// new clock, a single one is a wild time stamp.
std::vector<std::size_t> ClockBreaks(const std::vector<Timestamp>& times);

/// Rows after a clock was set back are counted on, `kClockGap` after the last one before: nobody knows how
/// much time has passed, and that is longer than anything is bridged.
inline constexpr std::chrono::seconds kClockGap(10);

/// What is to be added to the times from each break on.
struct ClockOffset {
  std::size_t from_row = 0;
  std::chrono::nanoseconds offset{0};
};
std::vector<ClockOffset> OffsetsThatCountOn(const std::vector<Timestamp>& times);

/// Applies the offsets of the images' clock to another sensor's rows, whose clock was set at the same times;
/// leaves them alone when it was set more or less often.
template <typename Row>
void CountOn(const std::vector<ClockOffset>& offsets, std::vector<Row>* rows) {
  std::vector<Timestamp> times;
  times.reserve(rows->size());
  for (const Row& row : *rows) times.push_back(row.t);
  const std::vector<std::size_t> breaks = ClockBreaks(times);
  if (breaks.size() != offsets.size()) return;
  for (std::size_t i = 0; i < breaks.size(); ++i) {
    const std::size_t end = i + 1 < breaks.size() ? breaks[i + 1] : rows->size();
    for (std::size_t row = breaks[i]; row < end; ++row) (*rows)[row].t = (*rows)[row].t + offsets[i].offset;
  }
}

/// "the clock was set back by 3600 s ...": one sentence for all of them; none: it never was.
std::optional<std::string> SentenceAbout(const std::vector<ClockOffset>& offsets);

/// Time stamps in another unit show by the frame rate: a sentence with the factor; none: the rate is one of
/// cameras. @param times  ascending
std::optional<std::string> StrangeRate(const std::vector<Timestamp>& times);

/// An IMU that has no sample while there are images is of another clock: a sentence with both times.
std::optional<std::string> OtherClockOfImu(const std::vector<Timestamp>& image_times,
                                           const std::vector<ImuSample>& samples);

}  // namespace terrace
