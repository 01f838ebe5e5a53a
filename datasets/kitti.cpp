// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/kitti.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "datasets/folder_sequence.h"
#include "datasets/frame_times.h"
#include "datasets/ground_truth.h"
#include "datasets/image_file.h"
#include "datasets/image_names.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using Projection = Eigen::Matrix<double, 3, 4>;

fs::path ImageFolder(const fs::path& path, int camera) { return path / ("image_" + std::to_string(camera)); }

/// The images of both cameras by frame. Names that are frame numbers are these; names that are times are
/// numbered in their order, left and right together.
class KittiImages {
 public:
  KittiImages() = default;
  KittiImages(const fs::path& path, int left, int right) : path_(path) {
    for (const int camera : {left, right}) names_[camera] = ListImageNames(ImageFolder(path, camera));
    if (!names_[left].are_times || !names_[right].are_times) return;
    for (const int camera : {left, right}) {
      for (const auto& [ns, name] : names_[camera].by_number) times_.push_back({ns});
    }
    std::sort(times_.begin(), times_.end());
    times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
  }

  /// Of a frame that may have no image: the name that it should have.
  fs::path File(int camera, std::int64_t index) const {
    const auto found = Find(camera, index);
    if (found) return ImageFolder(path_, camera) / *found;
    char name[32];
    std::snprintf(name, sizeof(name), "%06lld.png", static_cast<long long>(index));
    return ImageFolder(path_, camera) / name;
  }
  bool Has(int camera, std::int64_t index) const { return Find(camera, index).has_value(); }
  /// One more than the last frame's number.
  std::int64_t end() const {
    if (!times_.empty()) return static_cast<std::int64_t>(times_.size());
    std::int64_t end = 0;
    for (const auto& [camera, names] : names_) {
      if (!names.by_number.empty()) end = std::max(end, names.by_number.rbegin()->first + 1);
    }
    return end;
  }
  /// By frame; empty: names are no times.
  const std::vector<Timestamp>& times() const { return times_; }

 private:
  std::optional<std::string> Find(int camera, std::int64_t index) const {
    const auto names = names_.find(camera);
    if (names == names_.end()) return std::nullopt;
    std::int64_t number = index;
    if (!times_.empty()) {
      if (index < 0 || index >= end()) return std::nullopt;
      number = times_[static_cast<std::size_t>(index)].ns;
    }
    const auto found = names->second.by_number.find(number);
    if (found == names->second.by_number.end()) return std::nullopt;
    return found->second;
  }

  fs::path path_;
  std::map<int, ImageNames> names_;
  std::vector<Timestamp> times_;
};

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
ImageHeader FirstImageHeader(const KittiImages& images, int camera, std::vector<std::string>* problems) {
  constexpr int kFramesToTry = 10;
  std::string problem;
  for (int i = 0; i < kFramesToTry; ++i) {
    try {
      return ReadImageHeader(images.File(camera, i));
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

  const ImageHeader image = FirstImageHeader(KittiImages(path, out.left, out.right), out.left, problems);
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
  std::vector<Timestamp> all;
  for (const KittiTime& row : table.rows) all.push_back(row.t);
  const std::vector<ClockOffset> clock = OffsetsThatCountOn(all);
  CountOn(clock, &table.rows);
  if (const auto sentence = SentenceAbout(clock)) table.warnings.push_back(times.string() + ": " + *sentence);
  LeaveOutTimeJumps(times, "frame", &table);
  return table;
}

namespace {

/// Of times.txt, else of the images' names.
Table<KittiTime> TimesOf(const fs::path& path, const KittiImages& images) {
  if (fs::exists(path / "times.txt") || images.times().empty()) return ReadKittiTimes(path / "times.txt");
  Table<KittiTime> table;
  for (std::size_t i = 0; i < images.times().size(); ++i)
    table.rows.push_back({static_cast<std::int64_t>(i), images.times()[i]});
  return table;
}

}  // namespace

std::unique_ptr<Sequence> OpenKittiSequence(const fs::path& path) {
  std::vector<std::string> problems;
  SequenceInfo info;
  info.kind = SequenceKind::kKitti;
  info.path = path;
  const KittiCameras cameras = ReadCameras(path, &problems);
  const KittiImages images(path, cameras.left, cameras.right);
  Table<KittiTime> table = TimesOf(path, images);
  if (!table.problem.empty()) problems.push_back(table.problem);
  ThrowIfAny(problems);
  info.warnings = std::move(table.warnings);
  info.calibration = cameras.calibration;

  // Pieces of a recording often keep its whole times.txt.
  std::vector<KittiTime>& times = table.rows;
  const std::size_t num_times = times.size();
  const std::int64_t end = times.back().index + 1;
  const auto has_image = [&](const KittiTime& time) {
    return images.Has(cameras.left, time.index) || images.Has(cameras.right, time.index);
  };
  while (!times.empty() && !has_image(times.back())) times.pop_back();
  if (times.empty()) ThrowIfAny({(path / "times.txt").string() + ": no line belongs to an image"});
  if (times.size() < num_times) {
    info.warnings.push_back((path / "times.txt").string() + ": the last " +
                            Counted(static_cast<std::int64_t>(num_times - times.size()), "line") +
                            " left out: there are no images");
  }
  if (images.end() > end) {
    info.warnings.push_back((path / "times.txt").string() + ": ends before the images do: the last " +
                            Counted(images.end() - end, "frame") + " left out");
  }
  std::vector<FolderFrame> frames;
  for (const KittiTime& time : times) {
    frames.push_back(
        {time.t, images.File(cameras.left, time.index), images.File(cameras.right, time.index), {}});
  }
  info.has_true_poses = HasTrueTrajectory(path);
  return std::make_unique<FolderSequence>(std::move(info), std::move(frames), SensorSamples{},
                                          table.num_time_jumps);
}

}  // namespace terrace
