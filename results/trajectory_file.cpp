// SPDX-License-Identifier: BSD-3-Clause
#include "results/trajectory_file.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <system_error>

#include "core/file_bytes.h"
#include "core/print.h"
#include "results/text_lines.h"

namespace terrace {
namespace {

/// "1600000000.066666667" to exact nanoseconds; a double would lose the last three digits.
std::optional<Timestamp> ParseSeconds(const std::string& text) {
  const std::size_t point = text.find('.');
  const std::string whole = text.substr(0, point);
  std::string decimals = point == std::string::npos ? "" : text.substr(point + 1);
  if (whole.empty() || decimals.size() > 9) return std::nullopt;
  decimals.append(9 - decimals.size(), '0');
  const std::string digits = whole + decimals;
  Timestamp t;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), t.ns);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return t;
}

}  // namespace

std::string TrajectoryLine(const ResultPose& pose) {
  const Eigen::Vector3d t = pose.T_world_left.translation();
  const Eigen::Quaterniond q = Eigen::Quaterniond(pose.T_world_left.linear()).normalized();
  return Printed("%lld.%09lld %.9f %.9f %.9f %.9f %.9f %.9f %.9f",
                 static_cast<long long>(pose.t_capture.ns / 1'000'000'000),
                 static_cast<long long>(pose.t_capture.ns % 1'000'000'000), t.x(), t.y(), t.z(), q.x(), q.y(),
                 q.z(), q.w());
}

std::vector<ResultPose> ReadTrajectoryFile(const std::filesystem::path& path) {
  std::vector<ResultPose> poses;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    std::istringstream words(line);
    std::string time;
    double v[7];
    words >> time;
    for (double& x : v) words >> x;
    const std::optional<Timestamp> t = ParseSeconds(time);
    if (!words || !t) throw FileError(where + ": must be 'timestamp tx ty tz qx qy qz qw'");
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!(std::abs(q.norm() - 1.0) < 1e-2)) throw FileError(where + ": the quaternion must be a unit one");
    if (!poses.empty() && *t <= poses.back().t_capture) throw FileError(where + ": time must rise");
    ResultPose pose;
    pose.t_capture = *t;
    pose.T_world_left.linear() = q.normalized().toRotationMatrix();
    pose.T_world_left.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    if (!pose.T_world_left.translation().allFinite()) throw FileError(where + ": must be finite");
    poses.push_back(pose);
  });
  return poses;
}

}  // namespace terrace
