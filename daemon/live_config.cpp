// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live_config.h"

#include "core/field_problems.h"
#include "daemon/map_placing.h"

namespace terrace {

std::vector<std::string> LiveConfig::Problems() const {
  FieldProblems problems;
  problems.Require(url.find("://") != std::string::npos, "url", url,
                   "read provider://address, as LCM has it");
  problems.RequireWithin("imu_wait_ms", imu_wait_ms, 0.0, 1000.0);
  problems.RequireWithin("imu_gap_ms", imu_gap_ms, 1.0, 10000.0);
  problems.RequireWithin("max_time_jump_s", max_time_jump_s, 0.1, 3600.0);
  problems.RequireWithin("snapshot_period_s", snapshot_period_s, 0.1, 3600.0);
  problems.RequireWithin("deadline_ms", deadline_ms, 1.0, 60000.0);
  problems.Require(map_pose.empty() || BodyInMapFrom(map_pose), "map_pose", map_pose,
                   "be four numbers: x y z [m] and yaw [deg]");
  problems.Require(map_pose.empty() || !load_map.empty(), "map_pose", map_pose,
                   "be empty where load_map names no map");
  return problems.Take();
}

}  // namespace terrace
