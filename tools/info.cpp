// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/angles.h"
#include "core/file_bytes.h"
#include "core/time.h"
#include "datasets/ground_truth.h"
#include "datasets/image_file.h"
#include "datasets/lcm_log.h"
#include "datasets/sequence.h"
#include "datasets/text_table.h"
#include "evaluation/disparity_file.h"
#include "results/replay_result.h"
#include "stereo/rectifier.h"
#include "tools/commands.h"
#include "tools/folder_needs.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

constexpr double kMicro = 1e-6;

std::string Count(std::size_t count, const char* noun) {
  return Counted(static_cast<std::int64_t>(count), noun);
}

double Mebibytes(double bytes) { return bytes / (1024.0 * 1024.0); }

// ---- sequences

std::string DistortionName(const RawCamera& camera) {
  if (!camera.distorted()) return "no distortion";
  return camera.model == DistortionModel::kEquidistant ? "equidistant distortion"
                                                       : "radial-tangential distortion";
}

void PrintCameras(const StereoCalibration& calibration) {
  std::printf("  cameras: %dx%d, f %.1f px, %s, baseline %.4f m, %s\n", calibration.width, calibration.height,
              calibration.left.fx, DistortionName(calibration.left).c_str(), calibration.baseline_m(),
              calibration.rectified() ? "already rectified" : "to be rectified");
  const Rectifier rectifier(calibration);
  const StereoCamera& camera = rectifier.camera();
  const double view_x_deg = Degrees(2.0 * std::atan(0.5 * camera.width / camera.fx));
  const double view_y_deg = Degrees(2.0 * std::atan(0.5 * camera.height / camera.fy));
  std::printf(
      "  rectified: f %.1f px, view %.0f x %.0f deg; a disparity of 128 px is %.2f m away, one of 1 px %.0f "
      "m\n",
      camera.fx, view_x_deg, view_y_deg, camera.Depth(128.0), camera.Depth(1.0));
  if (!calibration.T_body_rawleft) {
    std::printf("  body: not known\n");
    return;
  }
  const Eigen::Vector3d p_body_left = calibration.T_body_rawleft->translation();
  const Eigen::Vector3d forward_body =
      calibration.T_body_rawleft->linear() * rectifier.R_rect_raw().transpose() * Eigen::Vector3d::UnitZ();
  const double pitch_deg = Degrees(std::asin(std::clamp(forward_body.z(), -1.0, 1.0)));
  std::printf("  body: left camera at (%.3f, %.3f, %.3f) m, looks %.1f deg %s the body's x-y plane\n",
              p_body_left.x(), p_body_left.y(), p_body_left.z(), std::abs(pitch_deg),
              pitch_deg < 0 ? "below" : "above");
}

void PrintSensors(const SequenceInfo& info) {
  std::string sensors;
  for (const auto& [present, name] :
       {std::pair{info.has_imu, "IMU"}, std::pair{info.has_attitude, "body attitude"},
        std::pair{info.has_legs, "leg odometry"}}) {
    if (present) sensors += (sensors.empty() ? "" : ", ") + std::string(name);
  }
  std::printf("  beside the images: %s\n", sensors.empty() ? "nothing" : sensors.c_str());
}

void PrintTruth(const fs::path& path) {
  if (HasTrueTrajectory(path)) {
    const TrueTrajectory truth = LoadTrueTrajectory(path);
    double length_m = 0.0;
    for (std::size_t i = 1; i < truth.poses.size(); ++i) {
      length_m +=
          (truth.poses[i].T_world_frame.translation() - truth.poses[i - 1].T_world_frame.translation())
              .norm();
    }
    const char* frame = truth.frame == TruthFrame::kBody      ? "body"
                        : truth.frame == TruthFrame::kRawLeft ? "raw left camera"
                                                              : "rectified left camera";
    std::printf("  truth: %zu poses of the %s, %.2f m long\n", truth.poses.size(), frame, length_m);
  }
  if (HasTrueScene(path)) {
    const TrueScene scene = LoadTrueScene(path);
    std::printf("  truth: %s, %s\n", Count(scene.polygons.size(), "plane").c_str(),
                Count(scene.staircases.size(), "staircase").c_str());
  }
}

void PrintSequence(const fs::path& path, const Sequence& sequence) {
  const SequenceInfo& info = sequence.info();
  const double duration_s = Seconds(info.t_last - info.t_first);
  std::printf("%s: %s\n", path.c_str(), Name(info.kind));
  std::printf("  stereo: %s over %.2f s", Counted(info.num_frames, "frame").c_str(), duration_s);
  if (info.num_frames > 1 && duration_s > 0.0) {
    std::printf(", %.1f per second", static_cast<double>(info.num_frames - 1) / duration_s);
  }
  std::printf("\n");
  PrintCameras(info.calibration);
  PrintSensors(info);
  PrintTruth(path);
  for (const std::string& warning : info.warnings) std::printf("  note: %s\n", warning.c_str());
}

// ---- LCM logs, of whatever robot

void PrintChannels(const fs::path& path) {
  const std::vector<LcmLogChannel> channels = ListLcmLogChannels(path);
  std::size_t name_width = 7;
  for (const LcmLogChannel& channel : channels) name_width = std::max(name_width, channel.name.size());
  std::printf("  %-*s  %-16s  %-16s %9s %9s %9s\n", static_cast<int>(name_width), "channel", "fingerprint",
              "type", "messages", "per s", "MiB");
  for (const LcmLogChannel& channel : channels) {
    const double duration_s = static_cast<double>(channel.utime_last - channel.utime_first) * kMicro;
    const double rate_hz =
        duration_s > 0.0 ? static_cast<double>(channel.num_messages - 1) / duration_s : 0.0;
    std::printf("  %-*s  %016llx  %-16s %9lld %9.1f %9.3f\n", static_cast<int>(name_width),
                channel.name.c_str(), static_cast<unsigned long long>(channel.fingerprint),
                channel.known ? channel.type.c_str() : "not ours",
                static_cast<long long>(channel.num_messages), rate_hz,
                Mebibytes(static_cast<double>(channel.num_bytes)));
  }
}

void DescribeLog(const fs::path& path) {
  try {
    PrintSequence(path, *OpenSequence(path));
  } catch (const SequenceError& error) {
    std::printf("%s: LCM log that cannot be replayed\n  %s\n", path.c_str(), error.what());
  }
  PrintChannels(path);
}

// ---- results

void PrintMap(const TerrainMap& map) {
  std::map<TerrainLabel, std::pair<int, double>> by_label;
  for (const auto& region : map.regions) {
    auto& [count, area_m2] = by_label[region->label];
    ++count;
    area_m2 += region->area_m2;
  }
  std::printf("  map: %s, %s\n", Count(map.regions.size(), "region").c_str(),
              Count(map.staircases.size(), "staircase").c_str());
  for (const auto& [label, sum] : by_label) {
    std::printf("    %-12s %5d of %8.2f m2\n", Name(label), sum.first, sum.second);
  }
  for (const Staircase& stairs : map.staircases) {
    std::printf(
        "    staircase %lld: %d risers of %.3f m, %d treads of %.3f m, %.2f m wide, foot at (%.2f, %.2f, "
        "%.2f), "
        "confidence %.2f\n",
        static_cast<long long>(stairs.id), stairs.num_risers, stairs.riser_m, stairs.num_treads,
        stairs.tread_m, stairs.width_m, stairs.base_world().x(), stairs.base_world().y(),
        stairs.base_world().z(), stairs.confidence);
  }
}

void PrintStats(const ReplayStats& stats) {
  std::printf("  replay: %lld frames, %lld tracked, %lld dropped, %.1f per second, peak memory %.0f MiB\n",
              static_cast<long long>(stats.frames), static_cast<long long>(stats.tracked),
              static_cast<long long>(stats.dropped), stats.rate_hz, stats.peak_rss_mib);
  const Eigen::Vector3d& down = stats.gravity.down_world;
  std::printf("  up: from %s, %.2f +- %.2f deg off z\n", Name(stats.gravity.source),
              Degrees(std::acos(std::clamp(-down.z(), -1.0, 1.0))), Degrees(stats.gravity.sigma_rad));
  std::printf("  octree: %lld cells, %.1f MiB with the regions\n", static_cast<long long>(stats.map_cells),
              Mebibytes(static_cast<double>(stats.map_bytes)));
}

void PrintTrajectory(const std::vector<ResultPose>& trajectory) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length_m +=
        (trajectory[i].T_world_left.translation() - trajectory[i - 1].T_world_left.translation()).norm();
  }
  std::printf("  trajectory: %s, %.2f m long\n", Count(trajectory.size(), "pose").c_str(), length_m);
}

bool IsResultFolder(const fs::path& path) {
  return fs::exists(path / "terrain_map.json") || fs::exists(path / "stats.json");
}

/// Says what there is; a file that an interrupted run did not leave is left out.
void DescribeResult(const fs::path& path) {
  std::printf("%s: result of a replay\n", path.c_str());
  if (fs::exists(path / "stats.json")) PrintStats(ReadStatsFile(path / "stats.json"));
  if (fs::exists(path / "trajectory.tum")) PrintTrajectory(ReadTrajectoryFile(path / "trajectory.tum"));
  if (fs::exists(path / "terrain_map.json")) PrintMap(ReadTerrainMapFile(path / "terrain_map.json"));
}

// ---- images

void DescribePfm(const fs::path& path) {
  const FloatImage image = ReadDisparityFile(path);
  std::vector<float> known;
  std::copy_if(image.data.begin(), image.data.end(), std::back_inserter(known),
               [](float value) { return std::isfinite(value); });
  std::printf("%s: PFM image of %dx%d, %.1f %% known", path.c_str(), image.width, image.height,
              100.0 * static_cast<double>(known.size()) / static_cast<double>(image.data.size()));
  if (!known.empty()) {
    const auto [low, high] = std::minmax_element(known.begin(), known.end());
    std::printf(", values %g to %g", *low, *high);
  }
  std::printf("\n");
}

template <typename Values>
void PrintRange(const Values& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const auto num_zero = std::count(values.begin(), values.end(), 0);
  std::printf(", values %d to %d, %.1f %% zero", int{*low}, int{*high},
              100.0 * static_cast<double>(num_zero) / static_cast<double>(values.size()));
}

void DescribeImage(const fs::path& path) {
  const ImageHeader header = ReadImageHeader(path);
  std::printf("%s: %s image of %dx%d, %d bits %s", path.c_str(), Name(header.format), header.width,
              header.height, header.bits, header.channels == 1 ? "grey" : "colour");
  if (header.format == ImageFormat::kPng && header.channels == 1 && header.bits == 16) {
    const Gray16Image image = ReadGray16Png(path);
    PrintRange(image.data);
    std::printf("; as a disparity image of ours up to %.2f px",
                *std::max_element(image.data.begin(), image.data.end()) / 256.0);
  } else {
    PrintRange(ReadGrayImage(path).data);
  }
  std::printf("\n");
}

/// A folder that cannot be played: everything that it lacks, not the first thing alone.
[[noreturn]] void SayWhatIsMissing(const fs::path& path, const std::string& otherwise) {
  std::string text;
  for (const std::string& sentence : FolderNeeds(path)) text += (text.empty() ? "" : "\n") + sentence;
  throw FileError(text.empty() ? otherwise : text);
}

void DescribeSequence(const fs::path& path) {
  std::unique_ptr<Sequence> sequence;
  try {
    sequence = OpenSequence(path);
  } catch (const SequenceError& error) {
    SayWhatIsMissing(path, error.what());
  }
  PrintSequence(path, *sequence);
}

void Describe(const fs::path& path) {
  if (!fs::exists(path)) throw FileError(path.string() + ": no such file or folder");
  if (const std::optional<SequenceKind> kind = RecogniseSequence(path)) {
    if (*kind == SequenceKind::kLcmLog) return DescribeLog(path);
    return DescribeSequence(path);
  }
  if (fs::is_directory(path)) {
    if (IsResultFolder(path)) return DescribeResult(path);
    SayWhatIsMissing(path, path.string() + ": neither a sequence nor a result of terraced replay");
  }
  if (path.extension() == ".pfm") return DescribePfm(path);
  if (path.extension() == ".json") {
    const TerrainMap map = ReadTerrainMapFile(path);
    std::printf("%s: terrain map\n", path.c_str());
    return PrintMap(map);
  }
  if (IsImageFile(path)) return DescribeImage(path);
  throw FileError(path.string() + ": neither a sequence nor a terrain map (.json) nor an image");
}

}  // namespace

void AddInfoCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("info", "Say in words what a sequence, log, result, map or image holds");
  auto path = std::make_shared<std::string>();
  command
      ->add_option("FILE", *path,
                   "an EuRoC ASL or KITTI odometry folder, any LCM log, a folder that a replay wrote, its "
                   "terrain_map.json, a .pfm, .png, .jpg or .pgm image")
      ->required();
  command->callback([path] { Describe(*path); });
}

}  // namespace terrace
