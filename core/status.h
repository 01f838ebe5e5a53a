// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/pose_estimate.h"
#include "core/reason_code.h"
#include "core/time.h"

namespace terrace {

enum class DaemonState {
  kStarting = 0,
  kRunning = 1,
  kDegraded = 2,
  kPaused = 3,
  kNoInput = 4,
  kNoCalibration = 5,
  kStopping = 6,
};
const char* Name(DaemonState state);  ///< "starting", "no calibration", ...
enum class InputSource { kLive = 0, kReplay = 1 };

/// How one stage fared over the last window.
struct StageStatus {
  std::string name;
  std::int64_t num_in = 0;
  std::int64_t num_out = 0;
  std::int64_t num_dropped = 0;
  int queue_depth = 0;
  double last_ms = 0.0;
  double p50_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
};

/// How one input fared. Counts run from the start of the daemon, the rate is over the last window.
struct InputStatus {
  std::string name;     ///< images, calibration, imu, body_prior, body_pose, command
  std::string channel;  ///< on which it is expected
  std::int64_t num_messages = 0;
  std::int64_t num_bad = 0;  ///< of those: no message of this type, or values that cannot be meant
  double rate_hz = 0.0;
  std::optional<double> age_ms;  ///< since the newest arrived; none: nothing has
};

/// What the daemon says about itself, once a second.
struct Status {
  Timestamp t;
  std::int64_t seq = 0;
  std::string version;
  std::string config_hash;
  std::int64_t uptime_ms = 0;
  DaemonState state = DaemonState::kStarting;
  InputSource source = InputSource::kLive;
  TrackingStatus tracking = TrackingStatus::kLost;
  GravitySource gravity_source = GravitySource::kAssumed;
  double window_s = 1.0;
  std::string reason;  ///< why degraded, bridging or lost; empty = well
  ReasonCode reason_code = ReasonCode::kNone;
  std::int64_t map_id = 0;   ///< as in TerrainMap; 0: there is no map yet
  std::int64_t map_seq = 0;  ///< newest state of the map that is out
  int epoch = 0;             ///< jumps of the world so far
  double fps_in = 0.0;
  double fps_out = 0.0;
  double age_p50_ms = 0.0;  ///< image time to terrain sent
  double age_p99_ms = 0.0;
  double age_max_ms = 0.0;
  std::int64_t num_deadline_missed = 0;
  std::int64_t num_bad_frames = 0;
  std::int64_t num_time_jumps = 0;
  std::int64_t num_decode_errors = 0;
  std::int64_t num_imu_gaps = 0;
  std::int64_t num_lost = 0;
  int num_matches = 0;
  int num_inliers = 0;
  double rms_px = 0.0;
  double dense_ratio = 0.0;  ///< share of pixels with a disparity
  double vertical_disparity_px = 0.0;
  std::int64_t num_octree_nodes = 0;
  int num_regions = 0;
  std::int64_t map_bytes = 0;
  std::int64_t rss_bytes = 0;
  double cpu = 0.0;  ///< cores in use
  std::vector<InputStatus> inputs;
  std::vector<StageStatus> stages;
};

}  // namespace terrace
