// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <map>
#include <span>
#include <string_view>

#include "core/file_bytes.h"
#include "core/print.h"
#include "datasets/ground_truth.h"
#include "datasets/kitti.h"
#include "datasets/lcm_log.h"
#include "datasets/sequence.h"
#include "datasets/text_table.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

fs::path BodyStates(const fs::path& sequence) {
  return sequence / "mav0" / "state_groundtruth_estimate0" / "data.csv";
}
fs::path RawLeftPoses(const fs::path& sequence) { return sequence / "groundtruth_tum.txt"; }
fs::path KittiPoses(const fs::path& sequence) { return sequence / "poses.txt"; }
/// What a stereo camera's own tracking said of its rectified left camera, good to some millimetres.
fs::path DeviceTracking(const fs::path& sequence) { return sequence / "zed_tracking.tum"; }

/// A pose from position and quaternion; none when the quaternion is far from a rotation.
std::optional<TimedPose> PoseOf(Timestamp t, const Eigen::Vector3d& position, const Eigen::Quaterniond& q) {
  if (std::abs(q.norm() - 1.0) > 0.01) return std::nullopt;
  TimedPose pose{t};
  pose.T_world_frame.linear() = q.normalized().toRotationMatrix();
  pose.T_world_frame.translation() = position;
  return pose;
}

/// Seconds with nine decimals as nanoseconds, without the rounding of a double at 1e9 s.
std::optional<Timestamp> ParseSeconds(std::string_view cell) {
  const std::size_t point = cell.find('.');
  const std::optional<std::int64_t> seconds = ParseInt64(cell.substr(0, point));
  constexpr std::int64_t kMaxSeconds = 9'000'000'000;
  if (!seconds || *seconds < 0 || *seconds > kMaxSeconds) return std::nullopt;
  std::string decimals(point == std::string_view::npos ? std::string_view() : cell.substr(point + 1));
  decimals.resize(9, '0');
  if (decimals.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  return Timestamp{*seconds * 1'000'000'000 + *ParseInt64(decimals)};
}

/// What a number that is no time in seconds may be; empty: nobody knows.
std::string WhyNoSeconds(const std::string& cell) {
  if (cell.find_first_of("eE") != std::string::npos && ParseDouble(cell))
    return "; " + cell + " is a rounded time: write all its digits, as numpy.savetxt does with fmt='%.9f'";
  const std::optional<std::int64_t> number = ParseInt64(std::string_view(cell).substr(0, cell.find('.')));
  constexpr double kYear2001_s = 1e9, kYear2255_s = 9e9;
  for (const double factor : {1e-3, 1e-6, 1e-9}) {
    const double seconds = number ? factor * static_cast<double>(*number) : 0.0;
    if (seconds >= kYear2001_s && seconds <= kYear2255_s)
      return Printed("; with the factor %g %s would be one", factor, cell.c_str());
  }
  return "";
}

std::vector<TimedPose> Rising(Table<TimedPose> table) {
  if (!table.problem.empty()) throw FileError(table.problem);
  OrderByTime(&table.rows, [](const TimedPose& pose) { return pose.t; });
  return std::move(table.rows);
}

TrueTrajectory LoadBodyStates(const fs::path& csv) {
  const auto parse = [](std::span<const std::string_view> cells) -> std::optional<TimedPose> {
    const std::optional<Timestamp> t = cells.empty() ? std::nullopt : ParseNanoseconds(cells[0]);
    const auto v = ParseDoubles(cells, 1, 7);
    if (!t || !v) return std::nullopt;
    return PoseOf(*t, {(*v)[0], (*v)[1], (*v)[2]}, {(*v)[3], (*v)[4], (*v)[5], (*v)[6]});
  };
  return {TruthFrame::kBody, Rising(ReadTable<TimedPose>(
                                 csv, ',', "a time stamp [ns], position and quaternion w x y z", parse))};
}

TrueTrajectory LoadTumPoses(const fs::path& txt, TruthFrame frame) {
  std::string why_not;
  const auto parse = [&](std::span<const std::string_view> cells) -> std::optional<TimedPose> {
    const std::optional<Timestamp> t = cells.empty() ? std::nullopt : ParseSeconds(cells[0]);
    const auto v = ParseDoubles(cells, 1, 7);
    if (!t && v && why_not.empty()) why_not = WhyNoSeconds(std::string(cells[0]));
    if (!t || !v) return std::nullopt;
    return PoseOf(*t, {(*v)[0], (*v)[1], (*v)[2]}, {(*v)[6], (*v)[3], (*v)[4], (*v)[5]});
  };
  Table<TimedPose> table =
      ReadTable<TimedPose>(txt, ' ', "a time [s], position and quaternion x y z w", parse);
  if (!table.problem.empty()) table.problem += why_not;
  return {frame, Rising(std::move(table))};
}

TrueTrajectory LoadKittiPoses(const fs::path& sequence) {
  const Table<KittiTime> times = ReadKittiTimes(sequence / "times.txt");
  if (!times.problem.empty()) throw FileError(times.problem);
  std::map<std::int64_t, Timestamp> time_of_line;
  for (const KittiTime& time : times.rows) time_of_line[time.index] = time.t;
  const Eigen::Vector3d p_cam0_left = ReadKittiCameras(sequence).p_cam0_left;

  std::int64_t num_lines = 0;
  const auto parse = [&](std::span<const std::string_view> cells) -> std::optional<TimedPose> {
    const auto time = time_of_line.find(num_lines++);
    const auto v = ParseDoubles(cells, 0, 12);
    if (time == time_of_line.end() || !v) return std::nullopt;
    const Eigen::Matrix<double, 3, 4> P =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(v->data());
    const Eigen::Matrix3d R = P.leftCols<3>();
    if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0) return std::nullopt;
    return PoseOf(time->second, P.col(3) + R * p_cam0_left, Eigen::Quaterniond(R).normalized());
  };
  return {TruthFrame::kRectifiedLeft,
          Rising(ReadTable<TimedPose>(KittiPoses(sequence), ' ', "12 numbers [R | t] for a line of times.txt",
                                      parse))};
}

}  // namespace

bool HasTrueTrajectory(const fs::path& sequence) {
  std::error_code error;
  if (RecogniseSequence(sequence) == SequenceKind::kLcmLog) return !LoadLcmLogTruth(sequence).poses.empty();
  return fs::exists(BodyStates(sequence), error) || fs::exists(RawLeftPoses(sequence), error) ||
         fs::exists(KittiPoses(sequence), error) || fs::exists(DeviceTracking(sequence), error);
}

TrueTrajectory LoadTrueTrajectory(const fs::path& sequence) {
  std::error_code error;
  if (fs::exists(RawLeftPoses(sequence), error))
    return LoadTumPoses(RawLeftPoses(sequence), TruthFrame::kRawLeft);
  if (fs::exists(BodyStates(sequence), error)) return LoadBodyStates(BodyStates(sequence));
  if (fs::exists(KittiPoses(sequence), error)) return LoadKittiPoses(sequence);
  if (fs::exists(DeviceTracking(sequence), error))
    return LoadTumPoses(DeviceTracking(sequence), TruthFrame::kRectifiedLeft);
  if (RecogniseSequence(sequence) == SequenceKind::kLcmLog) {
    TrueTrajectory truth = LoadLcmLogTruth(sequence);
    if (!truth.poses.empty()) return truth;
    throw FileError(sequence.string() + ": the log has no true poses");
  }
  throw FileError(sequence.string() +
                  ": has no true poses, neither groundtruth_tum.txt nor "
                  "mav0/state_groundtruth_estimate0/data.csv nor poses.txt nor zed_tracking.tum");
}

}  // namespace terrace
