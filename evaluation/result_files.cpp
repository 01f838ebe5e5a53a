// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/result_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <sstream>

#include "datasets/json_value.h"

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

/// Calls `use(line, place)` for every line that is neither empty nor a comment.
void ForEachLine(const std::filesystem::path& path,
                 const std::function<void(const std::string&, const std::string&)>& use) {
  std::istringstream in(ReadTextFile(path));
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    use(line, path.string() + ":" + std::to_string(number));
  }
}

std::optional<double> NumberOrNull(const JsonValue& json) {
  return json.IsNull() ? std::nullopt : std::optional(json.Number());
}

/// One list a ring, one entry a vertex.
std::vector<RegionEdge> ReadEdges(const JsonValue& json, const TerrainRegion& region) {
  std::vector<RegionEdge> edges;
  const std::vector<JsonValue> rings = json.Items();
  if (rings.size() != 1 + region.holes_world.size()) json.Fail("must have one list for each ring");
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Ring& ring = i == 0 ? region.outline_world : region.holes_world[i - 1];
    const std::vector<JsonValue> items = rings[i].Items();
    if (items.size() != ring.size()) rings[i].Fail("must have one entry for each vertex");
    for (const JsonValue& item : items) {
      const std::optional<EdgeKind> kind = EdgeKindFromName(item["kind"].Text());
      if (!kind) item["kind"].Fail("must be limit, drop, rise or joins");
      edges.push_back({*kind, NumberOrNull(item["step_m"]), NumberOrNull(item["sigma_m"])});
    }
  }
  return edges;
}

TerrainRegion ReadRegion(const JsonValue& json) {
  TerrainRegion region;
  region.id = json["id"].Integer();
  region.revision = static_cast<int>(json["revision"].Integer());
  const std::string label = json["label"].Text();
  const std::optional<TerrainLabel> known = TerrainLabelFromName(label);
  if (!known) json["label"].Fail("'" + label + "' is not a label");
  region.label = *known;
  region.confidence = json["confidence"].Number();
  region.plane_world = {json["normal"].UnitVector3(), json["offset_m"].Number()};
  region.rms_m = json["rms_m"].Number();
  region.area_m2 = json["area_m2"].Number();
  region.outline_world = json["outline"].Points();
  for (const JsonValue& hole : json["holes"].Items()) region.holes_world.push_back(hole.Points());
  if (!json["staircase"].IsNull()) region.staircase_id = json["staircase"].Integer();
  if (!json["step_index"].IsNull()) region.step_index = static_cast<int>(json["step_index"].Integer());
  region.first_seen.ns = json["first_seen_ns"].Integer();
  region.last_seen.ns = json["last_seen_ns"].Integer();
  // Maps of older versions have none of these.
  if (json.Has("predicted") && json["predicted"].Bool()) region.source = RegionSource::kPredicted;
  if (json.Has("why")) region.why = json["why"].Text();
  if (json.Has("edges")) region.edges = ReadEdges(json["edges"], region);
  return region;
}

Staircase ReadStaircase(const JsonValue& json) {
  Staircase staircase;
  staircase.id = json["id"].Integer();
  staircase.num_risers = static_cast<int>(json["num_steps"].Integer());
  staircase.num_treads = static_cast<int>(json["num_treads"].Integer());
  staircase.riser_m = json["riser_m"].Number();
  staircase.tread_m = json["tread_m"].Number();
  staircase.width_m = json["width_m"].Number();
  staircase.direction_up_world = json["direction_world"].UnitVector3();
  staircase.confidence = json["confidence"].Number();
  for (const JsonValue& id : json["region_ids"].Items()) staircase.region_ids.push_back(id.Integer());
  // The file has the middle of the foot edge; the edges follow from a straight flight.
  const Eigen::Vector3d base = json["base_world"].Vector3();
  const Eigen::Vector3d half_edge =
      0.5 * staircase.width_m * Eigen::Vector3d::UnitZ().cross(staircase.direction_up_world);
  const Eigen::Vector3d head = base +
                               staircase.num_treads * staircase.tread_m * staircase.direction_up_world +
                               staircase.num_risers * staircase.riser_m * Eigen::Vector3d::UnitZ();
  staircase.foot_edge_world = {base + half_edge, base - half_edge};
  staircase.head_edge_world = {head + half_edge, head - half_edge};
  staircase.pitch_rad = std::atan2(staircase.riser_m, staircase.tread_m);
  return staircase;
}

TrackingStatus ReadStatus(const JsonValue& json) {
  const std::string text = json.Text();
  for (TrackingStatus status :
       {TrackingStatus::kTracking, TrackingStatus::kBridging, TrackingStatus::kLost}) {
    if (text == Name(status)) return status;
  }
  json.Fail("must be tracking, bridging or lost");
}

GravitySource ReadGravitySource(const JsonValue& json) {
  const std::string text = json.Text();
  for (GravitySource source : {GravitySource::kImu, GravitySource::kAttitude, GravitySource::kMounting,
                               GravitySource::kPlane, GravitySource::kAssumed}) {
    if (text == Name(source)) return source;
  }
  json.Fail("must be imu, attitude, mounting, plane or assumed");
}

/// `<t_capture_ns>.png` of a folder, by time.
std::map<Timestamp, std::filesystem::path> ImagesIn(const std::filesystem::path& folder) {
  std::map<Timestamp, std::filesystem::path> images;
  if (!std::filesystem::is_directory(folder)) return images;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    // Other images of the folder (confidence, colour) have an underscore in the name.
    if (entry.path().extension() != ".png") continue;
    const std::string stem = entry.path().stem().string();
    Timestamp t;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), t.ns);
    if (error == std::errc() && end == stem.data() + stem.size()) images[t] = entry.path();
  }
  return images;
}

constexpr const char* kStageOrder[] = {"load",      "rectify", "disparity", "odometry", "decomposition",
                                       "modelling", "merging", "labels",    "publish"};

}  // namespace

std::vector<std::pair<std::string, StageTimes>> ReplayStats::StagesInOrder() const {
  std::vector<std::pair<std::string, StageTimes>> ordered;
  for (const char* name : kStageOrder) {
    if (const auto stage = stages.find(name); stage != stages.end()) ordered.emplace_back(*stage);
  }
  for (const auto& stage : stages) {
    if (std::find(std::begin(kStageOrder), std::end(kStageOrder), stage.first) == std::end(kStageOrder)) {
      ordered.emplace_back(stage);
    }
  }
  return ordered;
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

TerrainMap ReadTerrainMapFile(const std::filesystem::path& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonValue json(document, path.string());
  if (json["format"].Text() != "terrace-map") json["format"].Fail("must be terrace-map");
  if (json["version"].Integer() != 1) json["version"].Fail("only version 1 is known");
  TerrainMap map;
  map.t_capture.ns = json["t_capture_ns"].Integer();
  for (const JsonValue& item : json["regions"].Items()) {
    map.regions.push_back(std::make_shared<const TerrainRegion>(ReadRegion(item)));
  }
  for (const JsonValue& item : json["staircases"].Items()) map.staircases.push_back(ReadStaircase(item));
  return map;
}

std::vector<ResultFrame> ReadFramesFile(const std::filesystem::path& path) {
  std::vector<ResultFrame> frames;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    const nlohmann::json document = ParseJson(line, where);
    const JsonValue json(document, where);
    ResultFrame frame;
    frame.t_capture.ns = json["t_capture_ns"].Integer();
    frame.status = ReadStatus(json["status"]);
    frame.reason = json["reason"].Text();
    if (!json["covariance"].IsNull()) {
      const std::vector<double> rows = json["covariance"].Numbers(36);
      frame.covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(rows.data());
    }
    if (!json["latency_ms"].IsNull()) frame.latency_ms = json["latency_ms"].Number();
    frame.map_cells = json["map_cells"].Integer();
    frame.regions = json["regions"].Integer();
    if (json.Has("epoch")) frame.epoch = static_cast<int>(json["epoch"].Integer());
    frames.push_back(std::move(frame));
  });
  return frames;
}

std::vector<StaircaseReport> ReadStaircasesFile(const std::filesystem::path& path) {
  std::vector<StaircaseReport> reports;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    const nlohmann::json document = ParseJson(line, where);
    const JsonValue json(document, where);
    reports.push_back({{json["t_capture_ns"].Integer()}, ReadStaircase(json["staircase"])});
  });
  return reports;
}

ResultCamera ReadCameraFile(const std::filesystem::path& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonValue json(document, path.string());
  ResultCamera result;
  result.camera.width = static_cast<int>(json["width"].Integer());
  result.camera.height = static_cast<int>(json["height"].Integer());
  result.camera.fx = json["fx"].Number();
  result.camera.fy = json["fy"].Number();
  result.camera.cx = json["cx"].Number();
  result.camera.cy = json["cy"].Number();
  result.camera.baseline_m = json["baseline_m"].Number();
  const std::vector<double> rotation = json["R_rect_raw"].Numbers(9);
  result.R_rect_raw = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  if (!json["T_body_left"].IsNull()) {
    const std::vector<double> rows = json["T_body_left"].Numbers(16);
    result.T_body_left =
        Eigen::Isometry3d(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows.data()));
  }
  return result;
}

ReplayStats ReadStatsFile(const std::filesystem::path& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonValue json(document, path.string());
  ReplayStats stats;
  stats.frames = json["frames"].Integer();
  stats.tracked = json["tracked"].Integer();
  stats.dropped = json["dropped"].Integer();
  stats.rate_hz = json["rate_hz"].Number();
  stats.peak_rss_mib = json["peak_rss_mib"].Number();
  stats.map_bytes = json["map_bytes"].Integer();
  stats.map_cells = json["map_cells"].Integer();
  stats.map_sha256 = json["map_sha256"].Text();
  stats.gravity.down_world = json["gravity_world"].UnitVector3();
  stats.gravity.sigma_rad = json["gravity_sigma_deg"].Number() * EIGEN_PI / 180.0;
  stats.gravity.source = ReadGravitySource(json["gravity_source"]);
  if (const JsonValue latency = json["latency_ms"]; !latency.IsNull()) {
    stats.latency = {latency["p50"].Number(), latency["p90"].Number(), latency["p99"].Number(),
                     latency["max"].Number()};
  }
  for (const auto& [name, stage] : json["stages"].Members()) {
    stats.stages[name] = {stage["count"].Integer(), stage["cpu_ms_mean"].Number(), stage["p50_ms"].Number(),
                          stage["p90_ms"].Number(), stage["p99_ms"].Number(),      stage["max_ms"].Number()};
  }
  return stats;
}

std::vector<ResultTracks> ReadTracksFile(const std::filesystem::path& path) {
  std::vector<ResultTracks> frames;
  ForEachLine(path, [&](const std::string& line, const std::string& where) {
    const nlohmann::json document = ParseJson(line, where);
    const JsonValue json(document, where);
    ResultTracks tracks;
    tracks.frame = json["frame"].Integer();
    tracks.t_capture.ns = json["t_capture_ns"].Integer();
    tracks.sightings.is_keyframe = json["keyframe"].Bool();
    for (const LandmarkFate fate : kLandmarkFates) {
      for (const JsonValue& item : json[Name(fate)].Items()) {
        const std::vector<double> v = item.Numbers(3);  // ids are far below 2^53
        tracks.sightings.landmarks.push_back(
            {static_cast<std::int64_t>(v[0]), {static_cast<float>(v[1]), static_cast<float>(v[2])}, fate});
      }
    }
    if (!frames.empty() && tracks.frame <= frames.back().frame) json["frame"].Fail("must rise");
    frames.push_back(std::move(tracks));
  });
  return frames;
}

ReplayResult ReadReplayResult(const std::filesystem::path& folder) {
  ReplayResult result;
  result.folder = folder;
  result.trajectory = ReadTrajectoryFile(folder / "trajectory.tum");
  result.map = ReadTerrainMapFile(folder / "terrain_map.json");
  result.frames = ReadFramesFile(folder / "frames.jsonl");
  result.staircase_reports = ReadStaircasesFile(folder / "staircases.jsonl");
  result.camera = ReadCameraFile(folder / "camera.json");
  result.stats = ReadStatsFile(folder / "stats.json");
  result.map.gravity = result.stats.gravity;
  return result;
}

std::map<Timestamp, std::filesystem::path> SavedDisparities(const std::filesystem::path& result_folder) {
  return ImagesIn(result_folder / "disparity");
}

std::map<Timestamp, std::filesystem::path> SavedTrackImages(const std::filesystem::path& result_folder) {
  return ImagesIn(result_folder / "tracks");
}

}  // namespace terrace
