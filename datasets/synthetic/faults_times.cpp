// SPDX-License-Identifier: BSD-3-Clause
// Faults of clocks, and of images that do not come.
#include <chrono>
#include <cmath>

#include "datasets/synthetic/fault.h"
#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

using Change = std::function<Timestamp(Timestamp t)>;

/// Every time stamp of every sensor.
template <typename Condition>
void ChangeTimes(FaultyRecording& r, Condition condition, const Change& change) {
  const auto edit = [&](auto& rows) {
    for (auto& row : rows)
      if (condition(row.t)) row.t = change(row.t);
  };
  edit(r.left), edit(r.right), edit(r.imu), edit(r.attitude), edit(r.legs);
}

std::chrono::nanoseconds FromSeconds(double s) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(std::llround(1e9 * s)));
}

/// The clock of all sensors is set by so many seconds.
void SetClock(FaultyRecording& r, const FaultSpan& span, double by_s) {
  const auto by = FromSeconds(by_s);
  ChangeTimes(
      r, [&](Timestamp t) { return t >= span.t_begin; }, [by](Timestamp t) { return t + by; });
}

void LeaveImagesOut(FaultyRecording& r, Timestamp from, Timestamp until) {
  for (auto* images : {&r.left, &r.right})
    std::erase_if(*images, [&](const RecordedImage& image) { return image.t >= from && image.t < until; });
}

void Jitter(FaultyRecording& r, const FaultSpan&, double ms) {
  Random random(11);
  for (std::size_t i = 0; i < r.left.size(); ++i) {
    const auto by = FromSeconds(1e-3 * ms * random.Uniform(-1.0, 1.0));
    r.left[i].t = r.left[i].t + by;
    r.right[i].t = r.right[i].t + by;
  }
}

/// What was recorded first comes again, under later times: the player was started again.
void StartAgain(FaultyRecording& r, const FaultSpan& span, double) {
  const auto later = span.t_begin - r.left.front().t;
  const auto again = [&](auto& rows) {
    const auto all = rows;
    std::erase_if(rows, [&](const auto& row) { return row.t >= span.t_begin; });
    for (auto row : all) {
      row.t = row.t + later;
      rows.push_back(row);
    }
  };
  again(r.left), again(r.right), again(r.imu), again(r.attitude), again(r.legs);
}

}  // namespace

std::vector<Fault> TimeFaults() {
  const auto always = [](Timestamp) { return true; };
  return {
      {"clock_back", "all clocks are set back by so many seconds", 3600,
       [](FaultyRecording& r, const FaultSpan& span, double s) { SetClock(r, span, -s); }},
      {"clock_forward", "all clocks are set forward by so many seconds", 3600, SetClock},
      {"stamps_in_us", "all time stamps are in microseconds instead of nanoseconds", 1,
       [=](FaultyRecording& r, const FaultSpan&, double) {
         ChangeTimes(r, always, [](Timestamp t) { return Timestamp{t.ns / 1000}; });
       }},
      {"stamps_in_ms", "all time stamps are in milliseconds instead of nanoseconds", 1,
       [=](FaultyRecording& r, const FaultSpan&, double) {
         ChangeTimes(r, always, [](Timestamp t) { return Timestamp{t.ns / 1'000'000}; });
       }},
      {"stamps_times_1000", "all time stamps are a thousand times what they are", 1,
       [=](FaultyRecording& r, const FaultSpan&, double) {
         const std::int64_t first = r.left.front().t.ns;
         ChangeTimes(r, always, [first](Timestamp t) { return Timestamp{first + (t.ns - first) * 1000}; });
       }},
      {"stamps_jitter", "the images' time stamps are off by up to so many milliseconds", 10, Jitter},
      {"stamps_wild", "one image has a time stamp of so many seconds later", 1e6,
       [](FaultyRecording& r, const FaultSpan& span, double s) {
         r.left[span.begin].t = r.right[span.begin].t = r.left[span.begin].t + FromSeconds(s);
       }},
      {"stamps_repeated", "one time stamp comes again and again for a while", 1,
       [](FaultyRecording& r, const FaultSpan& span, double) {
         for (std::size_t i = span.begin; i < span.end; ++i) r.left[i].t = r.right[i].t = span.t_begin;
       }},
      {"silence", "the cameras are silent for so many seconds", 1,
       [](FaultyRecording& r, const FaultSpan& span, double s) {
         LeaveImagesOut(r, span.t_begin, span.t_begin + FromSeconds(s));
       }},
      {"stopped", "nothing comes from any sensor for so many seconds", 3,
       [](FaultyRecording& r, const FaultSpan& span, double s) {
         const Timestamp until = span.t_begin + FromSeconds(s);
         LeaveImagesOut(r, span.t_begin, until);
         const auto cut = [&](auto& rows) {
           std::erase_if(rows, [&](const auto& row) { return row.t >= span.t_begin && row.t < until; });
         };
         cut(r.imu), cut(r.attitude), cut(r.legs);
       }},
      {"every_third", "two of three images do not arrive", 3,
       [](FaultyRecording& r, const FaultSpan&, double every) {
         for (auto* images : {&r.left, &r.right}) {
           std::size_t n = 0;
           std::erase_if(*images,
                         [&](const RecordedImage&) { return n++ % static_cast<std::size_t>(every) != 0; });
         }
       }},
      {"player_again", "the player of a recording is started again", 1, StartAgain},
  };
}

}  // namespace terrace::synthetic
