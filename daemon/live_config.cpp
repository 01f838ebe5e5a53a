// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live_config.h"

#include <sstream>
#include <tuple>

#include "daemon/map_placing.h"

namespace terrace {

std::vector<std::string> LiveConfig::Problems() const {
  std::vector<std::string> problems;
  if (url.find("://") == std::string::npos) {
    problems.push_back("url = " + url + " must read provider://address, as LCM has it");
  }
  for (const auto& [name, value, min, max] : {std::tuple{"imu_wait_ms", imu_wait_ms, 0.0, 1000.0},
                                              std::tuple{"imu_gap_ms", imu_gap_ms, 1.0, 10000.0},
                                              std::tuple{"max_time_jump_s", max_time_jump_s, 0.1, 3600.0},
                                              std::tuple{"snapshot_period_s", snapshot_period_s, 0.1, 3600.0},
                                              std::tuple{"deadline_ms", deadline_ms, 1.0, 60000.0}}) {
    if (value >= min && value <= max) continue;
    std::ostringstream text;
    text << name << " = " << value << " must lie between " << min << " and " << max;
    problems.push_back(text.str());
  }
  if (!map_pose.empty() && !BodyInMapFrom(map_pose))
    problems.push_back("map_pose = '" + map_pose + "' must be four numbers: x y z [m] and yaw [deg]");
  if (!map_pose.empty() && load_map.empty())
    problems.push_back("map_pose = '" + map_pose + "' is the place in a map, but load_map names none");
  return problems;
}

}  // namespace terrace
