// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/result_writer.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <nlohmann/json.hpp>
#include <openssl/evp.h>
#include <sys/resource.h>

#include "core/check.h"
#include "datasets/image_file.h"

namespace terrace {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::array<const char*, 7> kFiles = {"trajectory.tum",   "terrain_map.json", "frames.jsonl",
                                               "staircases.jsonl", "camera.json",      "stats.json",
                                               "tracks.jsonl"};

/// Micrometres are enough for a vertex, and keep the file a third smaller.
Json Point(const Eigen::Vector3d& p) {
  const auto rounded = [](double v) { return std::round(v * 1e6) / 1e6 + 0.0; };
  return {rounded(p.x()), rounded(p.y()), rounded(p.z())};
}

Json Exact(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json RingJson(const Ring& ring) {
  Json points = Json::array();
  for (const Eigen::Vector3d& p : ring) points.push_back(Point(p));
  return points;
}

template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

/// One list a ring, outline first. Of a region without edges nothing is known beyond any.
Json EdgesJson(const TerrainRegion& region) {
  Json rings = Json::array();
  std::size_t next = 0;
  const auto add = [&](const Ring& ring) {
    Json edges = Json::array();
    for (std::size_t i = 0; i < ring.size(); ++i, ++next) {
      const RegionEdge edge = next < region.edges.size() ? region.edges[next] : RegionEdge{};
      edges.push_back(
          {{"kind", Name(edge.kind)}, {"step_m", OrNull(edge.step_m)}, {"sigma_m", OrNull(edge.sigma_m)}});
    }
    rings.push_back(std::move(edges));
  };
  add(region.outline_world);
  for (const Ring& hole : region.holes_world) add(hole);
  return rings;
}

Json RegionJson(const TerrainRegion& region) {
  Json holes = Json::array();
  for (const Ring& hole : region.holes_world) holes.push_back(RingJson(hole));
  return {{"id", region.id},
          {"revision", region.revision},
          {"label", Name(region.label)},
          {"confidence", region.confidence},
          {"normal", Exact(region.plane_world.normal)},
          {"offset_m", region.plane_world.offset_m},
          {"rms_m", region.rms_m},
          {"area_m2", region.area_m2},
          {"outline", RingJson(region.outline_world)},
          {"holes", holes},
          {"staircase", OrNull(region.staircase_id)},
          {"step_index", OrNull(region.step_index)},
          {"first_seen_ns", region.first_seen.ns},
          {"last_seen_ns", region.last_seen.ns},
          {"predicted", region.predicted()},
          {"why", region.why},
          {"edges", EdgesJson(region)}};
}

Json StaircaseJson(const Staircase& staircase) {
  return {{"id", staircase.id},
          {"num_steps", staircase.num_risers},
          {"num_treads", staircase.num_treads},
          {"riser_m", staircase.riser_m},
          {"tread_m", staircase.tread_m},
          {"width_m", staircase.width_m},
          {"direction_world", Exact(staircase.direction_up_world)},
          {"base_world", Point(staircase.base_world())},
          {"confidence", staircase.confidence},
          {"region_ids", staircase.region_ids}};
}

std::ofstream Open(const fs::path& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) throw OutputError(path.string() + ": cannot be written");
  return file;
}

void Write(const fs::path& path, const std::string& text) {
  std::ofstream file = Open(path);
  file << text;
  file.flush();
  if (!file) throw OutputError(path.string() + ": could not be written whole: is the disk full?");
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

Json LatencyJson(const Quantiles& q) {
  return {{"p50", q.p50}, {"p90", q.p90}, {"p99", q.p99}, {"max", q.max}};
}

}  // namespace

void PrepareOutputFolder(const fs::path& dir, bool overwrite) {
  std::error_code error;
  if (fs::exists(dir) && !fs::is_directory(dir)) throw OutputError(dir.string() + ": is not a folder");
  if (fs::exists(dir) && !fs::is_empty(dir, error)) {
    if (!overwrite) throw OutputError(dir.string() + ": must be empty or absent, or give --overwrite");
    for (const char* file : kFiles) fs::remove(dir / file, error);
    for (const char* images : {"disparity", "tracks"}) fs::remove_all(dir / images, error);
  }
  fs::create_directories(dir, error);
  if (error) throw OutputError(dir.string() + ": cannot be made: " + error.message());
}

std::string TerrainMapJson(const TerrainMap& map) {
  Json regions = Json::array();
  for (const auto& region : map.regions) regions.push_back(RegionJson(*region));
  Json staircases = Json::array();
  for (const Staircase& staircase : map.staircases) staircases.push_back(StaircaseJson(staircase));
  const Json json = {{"format", "terrace-map"}, {"version", 1},       {"t_capture_ns", map.t_capture.ns},
                     {"frame", "world"},        {"regions", regions}, {"staircases", staircases}};
  return json.dump() + "\n";
}

ResultWriter::ResultWriter(const fs::path& dir, const RigDescription& rig, int save_disparity_every)
    : dir_(dir),
      save_disparity_every_(save_disparity_every),
      trajectory_(Open(dir / "trajectory.tum")),
      frames_(Open(dir / "frames.jsonl")),
      staircases_(Open(dir / "staircases.jsonl")),
      map_(std::make_shared<const TerrainMap>()) {
  if (save_disparity_every_ > 0) fs::create_directories(dir_ / "disparity");
  trajectory_ << "# timestamp tx ty tz qx qy qz qw of T_world_left\n";
  WriteCamera(rig);
}

void ResultWriter::WriteCamera(const RigDescription& rig) const {
  const StereoCamera& camera = rig.camera;
  const auto row_major = [](const auto& matrix) {
    Json numbers = Json::array();
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
      for (Eigen::Index col = 0; col < matrix.cols(); ++col) numbers.push_back(matrix(row, col));
    }
    return numbers;
  };
  const Json json = {{"width", camera.width},
                     {"height", camera.height},
                     {"fx", camera.fx},
                     {"fy", camera.fy},
                     {"cx", camera.cx},
                     {"cy", camera.cy},
                     {"baseline_m", camera.baseline_m},
                     {"R_rect_raw", row_major(rig.R_rect_raw)},
                     {"T_body_left", rig.T_body_left ? row_major(rig.T_body_left->matrix()) : Json(nullptr)}};
  Write(dir_ / "camera.json", json.dump(1) + "\n");
}

void ResultWriter::AddFrame(const FrameResult& result, std::optional<double> latency_ms) {
  const PoseEstimate& pose = result.pose;
  const bool lost = pose.status == TrackingStatus::kLost;
  if (!lost) {
    const Eigen::Vector3d t = pose.T_world_left.translation();
    const Eigen::Quaterniond q = Eigen::Quaterniond(pose.T_world_left.linear()).normalized();
    std::array<char, 256> line{};
    std::snprintf(line.data(), line.size(), "%lld.%09lld %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n",
                  static_cast<long long>(pose.t_capture.ns / 1'000'000'000),
                  static_cast<long long>(pose.t_capture.ns % 1'000'000'000), t.x(), t.y(), t.z(), q.x(),
                  q.y(), q.z(), q.w());
    trajectory_ << line.data();
  }
  Json covariance = nullptr;
  if (!lost) {
    covariance = Json::array();
    for (int i = 0; i < 36; ++i) covariance.push_back(pose.covariance(i / 6, i % 6));
  }
  const Json line = {{"t_capture_ns", pose.t_capture.ns},
                     {"status", Name(pose.status)},
                     {"reason", pose.reason},
                     {"covariance", covariance},
                     {"latency_ms", OrNull(latency_ms)},
                     {"map_cells", result.change.map_cells},
                     {"regions", result.change.map->regions.size()},
                     {"epoch", pose.epoch}};
  frames_ << line.dump() << '\n';
  AddStaircases(*result.change.map);
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

void ResultWriter::AddStaircases(const TerrainMap& map) {
  for (const Staircase& staircase : map.staircases) {
    const std::string text = StaircaseJson(staircase).dump();
    std::string& written = staircase_lines_[staircase.id];
    if (text == written) continue;
    written = text;
    staircases_ << R"({"t_capture_ns":)" << map.t_capture.ns << R"(,"staircase":)" << text << "}\n";
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
      // 0 is the unknown, so that the smallest known disparity is 1/256.
      if (std::isfinite(value))
        image.data[i] = static_cast<std::uint16_t>(std::clamp(std::lround(value * 256.0F), 1L, 65535L));
    }
  }
  WritePng(dir_ / "disparity" / (std::to_string(disparity.t_capture.ns) + ".png"), image);
}

void ResultWriter::Finish(const RunTotals& totals) {
  const std::string map_json = TerrainMapJson(*map_);
  Write(dir_ / "terrain_map.json", map_json);
  Json stages = Json::object();
  for (const StageCost& cost : totals.stages) {
    stages[cost.name] = {{"count", cost.count},        {"cpu_ms_mean", cost.cpu_ms_mean},
                         {"p50_ms", cost.wall_ms.p50}, {"p90_ms", cost.wall_ms.p90},
                         {"p99_ms", cost.wall_ms.p99}, {"max_ms", cost.wall_ms.max}};
  }
  const Gravity& gravity = totals.gravity;
  const Json stats = {
      {"frames", num_frames_},
      {"tracked", num_tracking_ + num_bridging_},
      {"dropped", totals.num_dropped},
      {"passed_over", totals.num_passed_over},
      {"lessons_skipped", totals.num_lessons_skipped},
      {"rate_hz", totals.wall_s > 0 ? static_cast<double>(num_frames_) / totals.wall_s : 0.0},
      {"peak_rss_mib", PeakRssMib()},
      {"map_bytes", map_bytes_},
      {"map_cells", map_cells_},
      {"map_sha256", Sha256(map_json)},
      {"gravity_world", Exact(gravity.down_world)},
      {"gravity_sigma_deg", gravity.sigma_rad * 180.0 / std::numbers::pi},
      {"gravity_source", Name(gravity.source)},
      {"latency_ms",
       totals.realtime && latency_ms_.count() > 0 ? LatencyJson(latency_ms_.quantiles()) : Json(nullptr)},
      {"stages", stages}};
  Write(dir_ / "stats.json", stats.dump(1) + "\n");
  for (std::ofstream* file : {&trajectory_, &frames_, &staircases_}) {
    file->flush();
    if (!*file) throw OutputError(dir_.string() + ": results could not be written whole: is the disk full?");
  }
}

}  // namespace terrace
