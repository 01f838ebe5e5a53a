// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/time.h"

namespace terrace {

/// One line of trajectory.tum.
struct ResultPose {
  Timestamp t_capture;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
};

/// What the file begins with, as a line without its end.
inline constexpr const char* kTrajectoryHeading = "# timestamp tx ty tz qx qy qz qw of T_world_left";
/// Without the end of the line.
std::string TrajectoryLine(const ResultPose& pose);
/// Ascending in time. Throws FileError (core/file_bytes.h) with the file, the place and the rule that is
/// broken.
std::vector<ResultPose> ReadTrajectoryFile(const std::filesystem::path& path);

}  // namespace terrace
