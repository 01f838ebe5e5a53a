// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

/// How the live daemon listens and speaks. YAML section: `lcm`.
struct LiveConfig {
  /// LCM provider; the environment variable LCM_DEFAULT_URL stands in for a key that is not given. A receive
  /// buffer of 2 MB keeps images whole; net.core.rmem_max must allow it (config/60-terrace-lcm.conf).
  std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";
  /// Calibration of the rig, as files of any tool or device that `terrace calibration` reads, several of them with
  /// commas between, or a folder that holds mav0/. Empty: it comes as a message.
  std::string calibration = "";
  /// How long a pair of images waits for IMU samples up to its own time, which often arrive a little later.
  double imu_wait_ms = 100.0;
  /// IMU samples further apart than this count as a gap.
  double imu_gap_ms = 50.0;
  /// A time stamp this far ahead of the last one is believed only when the next one agrees.
  double max_time_jump_s = 10.0;
  /// The whole map is sent again after this time, for logs and subscribers that cannot ask for what they
  /// lack.
  double snapshot_period_s = 60.0;
  /// A map that is out later than this after its images were taken has missed its deadline, which is counted.
  double deadline_ms = 250.0;
  /// Folder into which the command SAVE_MAP may write, and from which LOAD_MAP reads; empty: that of
  /// --output, if there is one.
  std::string save_folder = "";
  /// A map to begin with, a file that SAVE_MAP wrote (NAME.terrace); empty: none.
  std::string load_map = "";
  /// Where the body is in that map with the first pose, as "x y z yaw" in metres and degrees. Empty: it is
  /// looked for by the views in the file, and until it is found the loaded map stands by itself on
  /// `channels.loaded_map`.
  std::string map_pose = "";

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
