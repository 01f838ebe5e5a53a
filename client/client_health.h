// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/pose_estimate.h"
#include "core/status.h"
#include "core/time.h"

namespace terrace {

/// How the daemon and the way to it are, as a client hears it.
struct ClientHealth {
  /// Since anything was heard from the daemon [s]: while it lives, under 1.5 also when the map does not
  /// change. None: nothing has been heard.
  std::optional<double> silence_s;
  /// Time of day less that of the newest image in map or pose [s]; meaningful when the clocks agree, and not
  /// in a replay. None: none has come.
  std::optional<double> image_age_s;
  std::optional<DaemonState> state;        ///< none: no status has come
  std::optional<TrackingStatus> tracking;  ///< of the newest pose; none: none has come
  std::string reason;            ///< what is wrong with tracking or daemon, in words; empty: nothing is
  bool in_step = false;          ///< the map is the newest that anybody has spoken of
  std::int64_t num_repairs = 0;  ///< times that something was missing and asked for
  std::int64_t num_bad_terrain =
      0;  ///< on the channel, but no terrain_v1_t: another version, or another program
  std::int64_t num_bad_pose = 0;    ///< likewise no pose_v1_t
  std::int64_t num_bad_status = 0;  ///< likewise no status_v1_t
};

}  // namespace terrace
