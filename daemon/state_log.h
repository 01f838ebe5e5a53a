// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/status.h"

namespace terrace {

/// What to do about it, for people; empty where nobody can tell.
std::string RemedyFor(ReasonCode reason);

/// What a status says that the one before did not: a sentence for the log when the daemon's state or tracking
/// changes, not one a second.
class StateLog {
 public:
  struct Line {
    bool is_trouble = false;
    std::string text;
  };

  /// Once a second, in order. None: nothing has changed.
  std::optional<Line> Add(const Status& status);

 private:
  struct Seen {
    DaemonState state;
    TrackingStatus tracking;
    ReasonCode reason_code;
    friend bool operator==(const Seen&, const Seen&) = default;
  };

  std::optional<Seen> last_;
  std::int64_t num_lost_ = 0;
  int epoch_ = 0;
};

}  // namespace terrace
