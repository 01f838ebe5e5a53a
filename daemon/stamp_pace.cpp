// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/stamp_pace.h"

#include <algorithm>
#include <cmath>

#include "core/print.h"

namespace terrace {

double StampPace::Add(Timestamp stamp, ArrivalTime arrived) {
  constexpr std::chrono::seconds kStretch(1);
  constexpr std::size_t kFewest = 5;
  if (!last_) begin_ = arrived;
  if (last_) stamp_steps_s_.push_back(Seconds(stamp - *last_));
  last_ = stamp;
  if (arrived - begin_ < kStretch || stamp_steps_s_.size() < kFewest) return factor_;
  // The middle step, since a clock that is set makes one that is large.
  const auto middle = stamp_steps_s_.begin() + static_cast<std::ptrdiff_t>(stamp_steps_s_.size() / 2);
  std::nth_element(stamp_steps_s_.begin(), middle, stamp_steps_s_.end());
  const double stamps_go_s = *middle * static_cast<double>(stamp_steps_s_.size());
  const double took_s = std::chrono::duration<double>(arrived - begin_).count();
  factor_ = 1.0;
  for (const double factor : {1e3, 1e6, 1e-3, 1e-6}) {
    constexpr double kLikely = 3.0;  // arrivals come in bursts, players go faster or slower
    if (stamps_go_s > 0.0 && std::abs(std::log(stamps_go_s * factor / took_s)) < std::log(kLikely))
      factor_ = factor;
  }
  stamp_steps_s_.clear();
  begin_ = arrived;
  return factor_;
}

std::string SentenceAboutPace(double factor) {
  return Printed(
      "its time stamps go %g times too %s: they are in another unit; with the factor %g they would be right",
      std::max(factor, 1.0 / factor), factor < 1.0 ? "fast" : "slowly", factor);
}

}  // namespace terrace
