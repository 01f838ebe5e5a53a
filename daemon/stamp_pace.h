// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/time.h"

namespace terrace {

/// Compares how fast the time stamps of live messages go with how fast the messages arrive: stamps in another
/// unit go a thousand times too fast or too slowly. A clock that is set, messages that are lost and a
/// recording that is played slowly do not look like that.
class StampPace {
 public:
  using ArrivalTime = std::chrono::steady_clock::time_point;

  /// @return the factor that would make the stamps right, 1e-6 to 1e6; 1 as long as nothing is wrong
  double Add(Timestamp stamp, ArrivalTime arrived);

 private:
  std::optional<Timestamp> last_;
  ArrivalTime begin_;                  // of the stretch that is looked at
  std::vector<double> stamp_steps_s_;  // in it
  double factor_ = 1.0;
};

/// One sentence about stamps that would need this factor.
std::string SentenceAboutPace(double factor);

}  // namespace terrace
