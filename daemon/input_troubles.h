// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/status.h"

namespace terrace {

/// Says in words which of the counters of what went wrong with the inputs have risen.
class InputTroubles {
 public:
  /// @param num_dropped  frames since the start that came while the odometry was behind
  /// @return what has gone wrong since the last call; empty: nothing
  std::string Take(const Status& status, std::int64_t num_dropped);

 private:
  std::array<std::int64_t, 5> counts_{};
};

}  // namespace terrace
