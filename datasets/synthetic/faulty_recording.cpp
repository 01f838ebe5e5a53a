// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/faulty_recording.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string_view>

#include "core/file_bytes.h"
#include "core/print.h"
#include "datasets/image_file.h"
#include "datasets/text_table.h"

namespace terrace::synthetic {
namespace {

namespace fs = std::filesystem;

using Cells = std::span<const std::string_view>;

template <typename Row, typename Parse>
std::vector<Row> ReadRows(const fs::path& csv, const std::string& rule, Parse parse) {
  Table<Row> table = ReadTable<Row>(csv, ',', rule, parse);
  if (!table.problem.empty()) throw FileError(table.problem);
  return std::move(table.rows);
}

std::vector<RecordedImage> ReadImages(const fs::path& camera) {
  return ReadRows<RecordedImage>(
      camera / "data.csv", "a time stamp [ns] and a file name",
      [&](Cells cells) -> std::optional<RecordedImage> {
        const auto t = cells.size() < 2 ? std::nullopt : ParseNanoseconds(cells[0]);
        if (!t) return std::nullopt;
        return RecordedImage{*t, *t, camera / "data" / std::string(cells[1]), {}, {}};
      });
}

std::vector<ImuSample> ReadImuSamples(const fs::path& csv) {
  if (!fs::exists(csv)) return {};
  return ReadRows<ImuSample>(
      csv, "a time stamp [ns] and 6 numbers", [](Cells cells) -> std::optional<ImuSample> {
        const auto t = cells.empty() ? std::nullopt : ParseNanoseconds(cells[0]);
        const auto v = ParseDoubles(cells, 1, 6);
        if (!t || !v) return std::nullopt;
        return ImuSample{*t, Eigen::Vector3d(v->data()), Eigen::Vector3d(v->data() + 3)};
      });
}

std::vector<RecordedPrior> ReadPriorRows(const fs::path& csv) {
  if (!fs::exists(csv)) return {};
  return ReadRows<RecordedPrior>(csv, "a time stamp [ns] and 13 numbers",
                                 [](Cells cells) -> std::optional<RecordedPrior> {
                                   const auto t = cells.empty() ? std::nullopt : ParseNanoseconds(cells[0]);
                                   const auto v = ParseDoubles(cells, 1, 13);
                                   if (!t || !v) return std::nullopt;
                                   RecordedPrior prior;
                                   prior.t = *t;
                                   std::copy(v->begin(), v->end(), prior.values.begin());
                                   return prior;
                                 });
}

void WriteText(const fs::path& path, const std::string& text) {
  WriteFileBytes(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void WriteImages(const std::vector<RecordedImage>& images, const fs::path& camera) {
  std::string list = "#timestamp [ns],filename\n";
  int n = 0;
  for (const RecordedImage& image : images) {
    // Two images may have the same time stamp.
    const std::string name = Printed("%06d.png", n++);
    const fs::path path = camera / "data" / name;
    Print(&list, "%lld,%s\n", static_cast<long long>(image.t.ns), name.c_str());
    if (image.bytes) {
      WriteFileBytes(path, *image.bytes);
    } else if (image.pixels) {
      WritePng(path, *image.pixels);
    } else {
      WriteFileBytes(path, ReadFileBytes(image.source));
    }
  }
  WriteText(camera / "data.csv", list);
}

void WriteImu(const std::vector<ImuSample>& samples, const fs::path& csv) {
  std::string text = "#timestamp [ns],w x y z [rad s^-1],a x y z [m s^-2]\n";
  for (const ImuSample& s : samples)
    Print(&text, "%lld,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f\n", static_cast<long long>(s.t.ns), s.gyro.x(),
          s.gyro.y(), s.gyro.z(), s.accel.x(), s.accel.y(), s.accel.z());
  WriteText(csv, text);
}

void WritePriors(const std::vector<RecordedPrior>& priors, const fs::path& csv) {
  std::string text = "#timestamp [ns],p x y z [m],q w x y z,sigma rotation x y z [rad],sigma p x y z [m]\n";
  for (const RecordedPrior& prior : priors) {
    Print(&text, "%lld", static_cast<long long>(prior.t.ns));
    for (const double value : prior.values) Print(&text, ",%.9f", value);
    text += '\n';
  }
  WriteText(csv, text);
}

/// A line for every left image, by its time as it is told.
void WriteTrueTimes(const FaultyRecording& recording, const fs::path& file) {
  std::map<std::int64_t, std::string> lines;
  TableReader truth(recording.source / file.filename(), ' ');
  if (!truth.problem().empty()) return;
  std::map<std::int64_t, std::string> poses;
  while (truth.Next()) {
    if (truth.cells().size() < 8) continue;
    const std::optional<double> t_s = ParseDouble(truth.cells()[0]);
    std::string pose;
    for (std::size_t i = 1; i < 8; ++i) pose += " " + std::string(truth.cells()[i]);
    if (t_s) poses[std::llround(*t_s * 1e9)] = pose;
  }
  for (const RecordedImage& image : recording.left) {
    // Seconds since 1970 as a number are good to a quarter of a microsecond.
    constexpr std::int64_t kRounding_ns = 1000;
    const auto pose = poses.lower_bound(image.t_true.ns - kRounding_ns);
    if (pose == poses.end() || pose->first > image.t_true.ns + kRounding_ns) continue;
    // Of images with the same time stamp all but the first are left out.
    if (lines.contains(image.t.ns)) continue;
    lines[image.t.ns] = Printed("%lld.%09lld", static_cast<long long>(image.t.ns / 1'000'000'000),
                                static_cast<long long>(image.t.ns % 1'000'000'000)) +
                        pose->second + "\n";
  }
  std::string text;
  for (const auto& [t, line] : lines) text += line;
  WriteText(file, text);
}

template <typename Row>
void Cut(std::vector<Row>& rows, Timestamp t_last) {
  std::erase_if(rows, [&](const Row& row) { return row.t > t_last; });
}

}  // namespace

GrayImage& RecordedImage::Edit() {
  if (!pixels) pixels = ReadGrayImage(source);
  return *pixels;
}

Eigen::Isometry3d RecordedPrior::T_odom_body() const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(values[3], values[4], values[5], values[6]).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(values.data());
  return T;
}

void RecordedPrior::Set(const Eigen::Isometry3d& T_odom_body) {
  const Eigen::Vector3d p = T_odom_body.translation();
  const Eigen::Quaterniond q(T_odom_body.linear());
  const std::array<double, 7> pose{p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
  std::copy(pose.begin(), pose.end(), values.begin());
}

void FaultyRecording::EndAt(Timestamp t_last) {
  Cut(left, t_last);
  Cut(right, t_last);
  Cut(imu, t_last);
  Cut(attitude, t_last);
  Cut(legs, t_last);
}

FaultyRecording ReadRecording(const fs::path& folder) {
  const fs::path mav = folder / "mav0";
  FaultyRecording recording;
  recording.source = folder;
  recording.left = ReadImages(mav / "cam0");
  recording.right = ReadImages(mav / "cam1");
  if (recording.left.size() != recording.right.size())
    throw FileError(folder.string() + ": cam0 and cam1 must have the same number of images");
  recording.imu = ReadImuSamples(mav / "imu0" / "data.csv");
  recording.attitude = ReadPriorRows(mav / "attitude0" / "data.csv");
  recording.legs = ReadPriorRows(mav / "legs0" / "data.csv");
  return recording;
}

void WriteRecording(const FaultyRecording& recording, const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(recording.source)) {
    const fs::path relative = fs::relative(entry.path(), recording.source);
    const bool of_camera = relative.string().starts_with("mav0/cam");
    if (of_camera && (relative.filename() == "data.csv" || relative.parent_path().filename() == "data"))
      continue;
    if (entry.is_directory()) {
      fs::create_directories(folder / relative);
    } else {
      fs::create_directories((folder / relative).parent_path());
      fs::copy_file(entry.path(), folder / relative, fs::copy_options::overwrite_existing);
    }
  }
  const fs::path mav = folder / "mav0";
  WriteTrueTimes(recording, folder / "groundtruth_tum.txt");
  for (const char* camera : {"cam0", "cam1"}) fs::create_directories(mav / camera / "data");
  WriteImages(recording.left, mav / "cam0");
  WriteImages(recording.right, mav / "cam1");
  if (fs::exists(mav / "imu0")) WriteImu(recording.imu, mav / "imu0" / "data.csv");
  if (fs::exists(mav / "attitude0")) WritePriors(recording.attitude, mav / "attitude0" / "data.csv");
  if (fs::exists(mav / "legs0")) WritePriors(recording.legs, mav / "legs0" / "data.csv");
}

}  // namespace terrace::synthetic
