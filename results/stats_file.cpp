// SPDX-License-Identifier: BSD-3-Clause
#include "results/stats_file.h"

#include <algorithm>
#include <iterator>
#include <numbers>

#include "results/json_text.h"

namespace terrace {
namespace {

GravitySource ReadGravitySource(const JsonValue& json) {
  const std::string text = json.Text();
  for (GravitySource source : {GravitySource::kImu, GravitySource::kAttitude, GravitySource::kMounting,
                               GravitySource::kPlane, GravitySource::kAssumed}) {
    if (text == Name(source)) return source;
  }
  json.Fail("must be imu, attitude, mounting, plane or assumed");
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

std::string StatsJson(const ReplayStats& stats) {
  OrderedJson stages = OrderedJson::object();
  for (const auto& [name, times] : stats.StagesInOrder()) {
    stages[name] = {{"count", times.count},   {"cpu_ms_mean", times.cpu_ms_mean}, {"p50_ms", times.p50_ms},
                    {"p90_ms", times.p90_ms}, {"p99_ms", times.p99_ms},           {"max_ms", times.max_ms}};
  }
  OrderedJson latency = nullptr;
  if (stats.latency) {
    latency = {{"p50", stats.latency->p50},
               {"p90", stats.latency->p90},
               {"p99", stats.latency->p99},
               {"max", stats.latency->max}};
  }
  const OrderedJson json = {{"frames", stats.frames},
                            {"tracked", stats.tracked},
                            {"dropped", stats.dropped},
                            {"passed_over", stats.passed_over},
                            {"lessons_skipped", stats.lessons_skipped},
                            {"rate_hz", stats.rate_hz},
                            {"peak_rss_mib", stats.peak_rss_mib},
                            {"map_bytes", stats.map_bytes},
                            {"map_cells", stats.map_cells},
                            {"map_sha256", stats.map_sha256},
                            {"gravity_world", VectorJson(stats.gravity.down_world)},
                            {"gravity_sigma_deg", stats.gravity.sigma_rad * 180.0 / std::numbers::pi},
                            {"gravity_source", Name(stats.gravity.source)},
                            {"latency_ms", latency},
                            {"stages", stages}};
  return Dumped(json, 1) + "\n";
}

ReplayStats ReadStatsFile(const std::filesystem::path& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonValue json(document, path.string());
  ReplayStats stats;
  stats.frames = json["frames"].Integer();
  stats.tracked = json["tracked"].Integer();
  stats.dropped = json["dropped"].Integer();
  // Results of older versions have neither.
  if (json.Has("passed_over")) stats.passed_over = json["passed_over"].Integer();
  if (json.Has("lessons_skipped")) stats.lessons_skipped = json["lessons_skipped"].Integer();
  stats.rate_hz = json["rate_hz"].Number();
  stats.peak_rss_mib = json["peak_rss_mib"].Number();
  stats.map_bytes = json["map_bytes"].Integer();
  stats.map_cells = json["map_cells"].Integer();
  stats.map_sha256 = json["map_sha256"].Text();
  stats.gravity.down_world = json["gravity_world"].UnitVector3();
  stats.gravity.sigma_rad = json["gravity_sigma_deg"].Number() * std::numbers::pi / 180.0;
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

}  // namespace terrace
