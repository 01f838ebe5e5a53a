// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/result_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include <openssl/evp.h>
#include <sys/resource.h>

#include "core/check.h"
#include "datasets/image_file.h"
#include "results/explanations_file.h"
#include "results/frames_file.h"
#include "results/map_file.h"
#include "results/replay_result.h"
#include "results/stats_file.h"
#include "results/trajectory_file.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

std::ofstream Open(const fs::path& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) throw OutputError(path.string() + ": cannot be written");
  return file;
}

void Write(const fs::path& path, const std::string& text) {
  std::ofstream file = Open(path);
  file << text;
  file.flush();
  if (!file) throw std::runtime_error(path.string() + ": could not be written whole: is the disk full?");
}

std::string Sha256(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  TERRACE_CHECK(EVP_Digest(text.data(), text.size(), digest.data(), &size, EVP_sha256(), nullptr) == 1);
  std::string hex;
  for (unsigned int i = 0; i < size; ++i) {
    std::array<char, 3> byte{};
    std::snprintf(byte.data(), byte.size(), "%02x", digest[i]);
    hex += byte.data();
  }
  return hex;
}

double PeakRssMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace

void PrepareOutputFolder(const fs::path& dir, bool overwrite) {
  std::error_code error;
  if (fs::exists(dir) && !fs::is_directory(dir)) throw OutputError(dir.string() + ": is not a folder");
  if (fs::exists(dir) && !fs::is_empty(dir, error)) {
    if (!overwrite) throw OutputError(dir.string() + ": must be empty or absent, or give --overwrite");
    RemoveResults(dir);
  }
  fs::create_directories(dir, error);
  if (error) throw OutputError(dir.string() + ": cannot be made: " + error.message());
}

ResultWriter::ResultWriter(const fs::path& dir, const ResultCamera& camera, int save_disparity_every)
    : dir_(dir),
      save_disparity_every_(save_disparity_every),
      trajectory_(Open(dir / "trajectory.tum")),
      frames_(Open(dir / "frames.jsonl")),
      staircases_(Open(dir / "staircases.jsonl")),
      map_(std::make_shared<const TerrainMap>()) {
  if (save_disparity_every_ > 0) fs::create_directories(dir_ / "disparity");
  trajectory_ << kTrajectoryHeading << '\n';
  Write(dir_ / "camera.json", CameraJson(camera));
}

void ResultWriter::AddFrame(const FrameResult& result, std::optional<double> latency_ms) {
  const PoseEstimate& pose = result.pose;
  const bool lost = pose.status == TrackingStatus::kLost;
  if (!lost) trajectory_ << TrajectoryLine({pose.t_capture, pose.T_world_left}) << '\n';
  ResultFrame line;
  line.t_capture = pose.t_capture;
  line.status = pose.status;
  line.reason = pose.reason;
  if (!lost) line.covariance = pose.covariance;
  line.latency_ms = latency_ms;
  line.map_cells = result.change.map_cells;
  line.regions = static_cast<std::int64_t>(result.change.map->regions.size());
  line.epoch = pose.epoch;
  frames_ << FrameLine(line) << '\n';
  AddStaircases(result.change);
  // Told when it happens, and not after an hour.
  if (!trajectory_ || !frames_ || !staircases_)
    throw std::runtime_error(dir_.string() + ": results could not be written: is the disk full?");
  if (save_disparity_every_ > 0 && num_frames_ % save_disparity_every_ == 0 && result.disparity) {
    WriteDisparity(*result.disparity);
  }
  if (latency_ms) latency_ms_.Add(*latency_ms);
  ++num_frames_;
  num_tracking_ += pose.status == TrackingStatus::kTracking;
  num_bridging_ += pose.status == TrackingStatus::kBridging;
  num_lost_ += lost;
  map_cells_ = result.change.map_cells;
  map_bytes_ = result.change.map_bytes;
  map_ = result.change.map;
}

void ResultWriter::AddStaircases(const MapChange& change) {
  const TerrainMap& map = *change.map;
  for (const Staircase& staircase : map.staircases) {
    const auto& changed = change.changed_staircases;
    if (change.before && !std::binary_search(changed.begin(), changed.end(), staircase.id)) continue;
    // By itself, so that the time does not count as a change.
    const std::string text = StaircaseLine({{}, staircase});
    std::string& written = staircase_lines_[staircase.id];
    if (text == written) continue;
    written = text;
    staircases_ << StaircaseLine({map.t_capture, staircase}) << '\n';
  }
}

void ResultWriter::WriteDisparity(const DisparityImage& disparity) const {
  const cv::Mat1f& px = disparity.disparity_px;
  Gray16Image image{px.cols, px.rows, {}};
  image.data.resize(static_cast<std::size_t>(px.cols) * static_cast<std::size_t>(px.rows));
  std::size_t i = 0;
  for (int row = 0; row < px.rows; ++row) {
    for (int col = 0; col < px.cols; ++col, ++i) {
      const float value = px(row, col);
      if (!std::isfinite(value)) continue;
      // 0 is the unknown, so that the smallest known disparity is 1/256; what has no room is left unknown.
      const long sample = std::max(std::lround(value * 256.0F), 1L);
      if (sample <= 65535) image.data[i] = static_cast<std::uint16_t>(sample);
    }
  }
  WritePng(dir_ / "disparity" / (std::to_string(disparity.t_capture.ns) + ".png"), image);
}

void ResultWriter::Finish(const RunTotals& totals) {
  const std::string map_json = TerrainMapJson(*map_);
  Write(dir_ / "terrain_map.json", map_json);
  Write(dir_ / "explanations.jsonl", ExplanationsText(totals.explanations));
  ReplayStats stats;
  stats.frames = num_frames_;
  stats.tracked = num_tracking_ + num_bridging_;
  stats.dropped = totals.num_dropped;
  stats.passed_over = totals.num_passed_over;
  stats.lessons_skipped = totals.num_lessons_skipped;
  stats.rate_hz = totals.wall_s > 0 ? static_cast<double>(num_frames_) / totals.wall_s : 0.0;
  stats.peak_rss_mib = PeakRssMib();
  stats.map_bytes = map_bytes_;
  stats.map_cells = map_cells_;
  stats.map_sha256 = Sha256(map_json);
  stats.gravity = totals.gravity;
  if (totals.realtime && latency_ms_.count() > 0) {
    const Quantiles q = latency_ms_.quantiles();
    stats.latency = LatencyMs{q.p50, q.p90, q.p99, q.max};
  }
  for (const StageCost& cost : totals.stages) {
    stats.stages[cost.name] = {cost.count,       cost.cpu_ms_mean, cost.wall_ms.p50,
                               cost.wall_ms.p90, cost.wall_ms.p99, cost.wall_ms.max};
  }
  Write(dir_ / "stats.json", StatsJson(stats));
  for (std::ofstream* file : {&trajectory_, &frames_, &staircases_}) {
    file->flush();
    if (!*file) throw OutputError(dir_.string() + ": results could not be written whole: is the disk full?");
  }
}

}  // namespace terrace
