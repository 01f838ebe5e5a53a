// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/frame_times.h"

#include <algorithm>

#include "core/print.h"

namespace terrace {
namespace {

constexpr std::chrono::seconds kAgree(10);  // two rows of one clock lie this near
constexpr std::chrono::seconds kBack(1);    // less is messages that overtake one another
/// More often is a list that was never in order.
constexpr std::size_t kMostBreaks = 8;

bool Follows(Timestamp before, Timestamp after) { return after > before && after - before <= kAgree; }

}  // namespace

std::vector<std::size_t> ClockBreaks(const std::vector<Timestamp>& times) {
  std::vector<std::size_t> breaks;
  if (times.empty()) return breaks;
  Timestamp last = times.front();
  for (std::size_t i = 1; i < times.size(); ++i) {
    const bool confirmed = i + 1 < times.size() && Follows(times[i], times[i + 1]);
    if (confirmed && last - times[i] > kBack) breaks.push_back(i);
    if (confirmed || Follows(last, times[i])) last = times[i];
  }
  if (breaks.size() > kMostBreaks) breaks.clear();
  return breaks;
}

std::vector<ClockOffset> OffsetsThatCountOn(const std::vector<Timestamp>& times) {
  std::vector<ClockOffset> offsets;
  Timestamp end;  // of what came before, counted on
  std::size_t begin = 0;
  std::chrono::nanoseconds offset{0};
  for (const std::size_t from : ClockBreaks(times)) {
    // A wild time stamp must not move all that follows.
    for (std::size_t i = std::max<std::size_t>(begin, 1); i < from; ++i)
      if (i == begin || Follows(times[i - 1], times[i])) end = times[i] + offset;
    offset = end + kClockGap - times[from];
    offsets.push_back({from, offset});
    begin = from;
  }
  return offsets;
}

std::optional<std::string> SentenceAbout(const std::vector<ClockOffset>& offsets) {
  if (offsets.empty()) return std::nullopt;
  return Printed(
      "the clock was set back %zu time%s, first at row %zu: what follows is counted on after a gap of "
      "%lld s, and a new map begins there unless the place is recognised",
      offsets.size(), offsets.size() == 1 ? "" : "s", offsets.front().from_row + 1,
      static_cast<long long>(kClockGap.count()));
}

std::optional<std::string> StrangeRate(const std::vector<Timestamp>& times) {
  constexpr std::size_t kFewest = 4;
  constexpr double kMostHz = 1000.0, kLeastHz = 0.05;
  if (times.size() < kFewest) return std::nullopt;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < times.size(); ++i) steps_s.push_back(Seconds(times[i] - times[i - 1]));
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  const double rate_hz = 1.0 / std::max(*middle, 1e-9);
  if (rate_hz <= kMostHz && rate_hz >= kLeastHz) return std::nullopt;
  for (const double factor : {1e3, 1e6, 1e9, 1e-3, 1e-6, 1e-9}) {
    const double meant_hz = rate_hz / factor;
    if (meant_hz > kMostHz || meant_hz < kLeastHz) continue;
    return Printed(
        "%.3g frames a second: the time stamps seem to be in another unit; with the factor %g it would be "
        "%.3g frames a second",
        rate_hz, factor, meant_hz);
  }
  return Printed("%.3g frames a second: the time stamps cannot be right", rate_hz);
}

std::optional<std::string> OtherClockOfImu(const std::vector<Timestamp>& image_times,
                                           const std::vector<ImuSample>& samples) {
  if (image_times.empty() || samples.empty()) return std::nullopt;
  if (samples.front().t <= image_times.back() && samples.back().t >= image_times.front()) return std::nullopt;
  const auto seconds = [](Timestamp t) { return 1e-9 * static_cast<double>(t.ns); };
  return Printed(
      "the IMU has samples of %.3f to %.3f s, the images are of %.3f to %.3f s: its clock, or the unit of "
      "its "
      "time stamps, is another one, and it is of no use",
      seconds(samples.front().t), seconds(samples.back().t), seconds(image_times.front()),
      seconds(image_times.back()));
}

}  // namespace terrace
