// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/input_troubles.h"

#include <utility>

#include "core/print.h"

namespace terrace {

std::string InputTroubles::Take(const Status& status, std::int64_t num_dropped) {
  constexpr std::array<const char*, 5> kWords = {
      "unreadable pairs of images", "messages that are not taken", "images whose time does not rise",
      "gaps in the samples of the IMU, or samples that came too late",
      "frames that came while the odometry was behind"};
  const std::array<std::int64_t, 5> counts = {status.num_bad_frames, status.num_decode_errors,
                                              status.num_time_jumps, status.num_imu_gaps, num_dropped};
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::int64_t news = counts[i] - std::exchange(counts_[i], counts[i]);
    if (news > 0)
      text += Printed("%s%lld %s", text.empty() ? "" : ", ", static_cast<long long>(news), kWords[i]);
  }
  return text.empty() ? text : "since the last status: " + text;
}

}  // namespace terrace
