// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/kitti.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "datasets/folder_sequence.h"
#include "datasets/ground_truth.h"
#include "datasets/image_file.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using Projection = Eigen::Matrix<double, 3, 4>;

fs::path ImageFolder(const fs::path& path, int camera) { return path / ("image_" + std::to_string(camera)); }

fs::path ImageFile(const fs::path& path, int camera, std::int64_t index) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06lld.png", static_cast<long long>(index));
  return ImageFolder(path, camera) / name;
}

std::map<int, Projection> ReadProjections(const fs::path& calib, std::vector<std::string>* problems) {
  using Row = std::pair<int, Projection>;
  const Table<Row> table =
      ReadTable<Row>(calib, ' ', "P0: to P3: with 12 numbers", [](std::span<const std::string_view> cells) {
        std::optional<Row> row;
        constexpr std::array<std::string_view, 4> kNames = {"P0:", "P1:", "P2:", "P3:"};
        if (cells.empty()) return row;
        const auto name = std::find(kNames.begin(), kNames.end(), cells[0]);
        const auto values = ParseDoubles(cells, 1, 12);
        if (name == kNames.end() || !values) return row;
        row = Row{static_cast<int>(name - kNames.begin()),
                  Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(values->data())};
        return row;
      });
  if (!table.problem.empty()) problems->push_back(table.problem);
  return {table.rows.begin(), table.rows.end()};
}

/// Of the first image that can be read.
ImageHeader FirstImageHeader(const fs::path& path, int camera, std::vector<std::string>* problems) {
  constexpr int kFramesToTry = 10;
  std::string problem;
  for (int i = 0; i < kFramesToTry; ++i) {
    try {
      return ReadImageHeader(ImageFile(path, camera, i));
    } catch (const FileError& error) {
      if (problem.empty()) problem = error.what();
    }
  }
  problems->push_back(problem);
  return {};
}

KittiCameras ReadCameras(const fs::path& path, std::vector<std::string>* problems) {
  KittiCameras out;
  const bool grey = fs::exists(ImageFolder(path, 0)) || fs::exists(ImageFolder(path, 1));
  if (!grey) {
    out.left = 2;
    out.right = 3;
  }
  for (const int camera : {out.left, out.right}) {
    if (!fs::is_directory(ImageFolder(path, camera))) {
      problems->push_back(ImageFolder(path, camera).string() +
                          ": no such folder, must hold the images of camera " + std::to_string(camera));
    }
  }
  StereoCalibration& calibration = out.calibration;
  calibration.name = (path / "calib.txt").string();
  const std::map<int, Projection> projections = ReadProjections(path / "calib.txt", problems);
  if (projections.empty() || !problems->empty()) return out;
  for (const int camera : {out.left, out.right}) {
    if (!projections.contains(camera)) {
      problems->push_back(calibration.name + ": holds no line P" + std::to_string(camera) +
                          ": with 12 numbers");
    }
  }
  if (!problems->empty()) return out;

  const ImageHeader image = FirstImageHeader(path, out.left, problems);
  if (!problems->empty()) return out;
  calibration.width = image.width;
  calibration.height = image.height;
  // P_i = K [I | t_i] with p_cam_i = p_cam0 + t_i.
  const auto camera_of = [](const Projection& P) {
    return RawCamera{P(0, 0), P(1, 1), P(0, 2), P(1, 2), DistortionModel::kRadialTangential, {}};
  };
  const auto offset_of = [](const Projection& P) -> Eigen::Vector3d {
    return P.leftCols<3>().triangularView<Eigen::Upper>().solve(P.col(3));
  };
  const Projection& P_left = projections.at(out.left);
  const Projection& P_right = projections.at(out.right);
  calibration.left = camera_of(P_left);
  calibration.right = camera_of(P_right);
  // The images are rectified: rows are aligned, and what P2 and P3 say about y and z (2 mm) is left over from
  // how KITTI's four cameras were rectified together.
  calibration.T_rawright_rawleft.translation().x() = offset_of(P_right).x() - offset_of(P_left).x();
  out.p_cam0_left = -offset_of(P_left);
  Eigen::Isometry3d T_body_left = Eigen::Isometry3d::Identity();
  T_body_left.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  calibration.T_body_rawleft = T_body_left;
  const std::vector<std::string> senseless = calibration.Problems();
  problems->insert(problems->end(), senseless.begin(), senseless.end());
  return out;
}

}  // namespace

KittiCameras ReadKittiCameras(const fs::path& path) {
  std::vector<std::string> problems;
  KittiCameras cameras = ReadCameras(path, &problems);
  ThrowIfAny(problems);
  return cameras;
}

Table<KittiTime> ReadKittiTimes(const fs::path& times) {
  std::int64_t num_lines = 0;
  const auto parse = [&](std::span<const std::string_view> cells) -> std::optional<KittiTime> {
    const std::int64_t index = num_lines++;
    const std::optional<double> t_s = cells.empty() ? std::nullopt : ParseDouble(cells[0]);
    constexpr double kMaxSeconds = 9e9;  // nanoseconds since the epoch end at 9.2e9 s
    if (!t_s || *t_s < 0.0 || *t_s > kMaxSeconds) return std::nullopt;
    return KittiTime{index, {std::llround(*t_s * 1e9)}};
  };
  Table<KittiTime> table = ReadTable<KittiTime>(times, ' ', "one time [s]", parse);
  LeaveOutTimeJumps(times, "frame", &table);
  return table;
}

std::unique_ptr<Sequence> OpenKittiSequence(const fs::path& path) {
  std::vector<std::string> problems;
  SequenceInfo info;
  info.kind = SequenceKind::kKitti;
  info.path = path;
  const KittiCameras cameras = ReadCameras(path, &problems);
  Table<KittiTime> table = ReadKittiTimes(path / "times.txt");
  if (!table.problem.empty()) problems.push_back(table.problem);
  ThrowIfAny(problems);
  info.warnings = std::move(table.warnings);
  info.calibration = cameras.calibration;

  // Pieces of a recording often keep its whole times.txt.
  const auto has_image = [&](const KittiTime& time) {
    return fs::exists(ImageFile(path, cameras.left, time.index)) ||
           fs::exists(ImageFile(path, cameras.right, time.index));
  };
  std::vector<KittiTime>& times = table.rows;
  const std::size_t num_times = times.size();
  while (!times.empty() && !has_image(times.back())) times.pop_back();
  if (times.empty()) ThrowIfAny({(path / "times.txt").string() + ": no line belongs to an image"});
  if (times.size() < num_times) {
    info.warnings.push_back((path / "times.txt").string() + ": the last " +
                            Counted(static_cast<std::int64_t>(num_times - times.size()), "line") +
                            " left out: there are no images");
  }
  std::vector<FolderFrame> frames;
  for (const KittiTime& time : times) {
    frames.push_back(
        {time.t, ImageFile(path, cameras.left, time.index), ImageFile(path, cameras.right, time.index), {}});
  }
  info.has_true_poses = HasTrueTrajectory(path);
  return std::make_unique<FolderSequence>(std::move(info), std::move(frames), SensorSamples{},
                                          table.num_time_jumps);
}

}  // namespace terrace
