// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_recording.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include <nlohmann/json.hpp>

#include "core/print.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/terrain_codec.h"
#include "tools/view_feed.h"
#include "tools/view_images.h"
#include "tools/view_page.h"

namespace terrace {
namespace {

using Rows = std::vector<std::pair<std::string, std::string>>;

/// The last element of a folder's name, also of "out/demo/".
std::string NameOf(const std::filesystem::path& path) {
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

double LengthOf(const std::vector<ResultPose>& trajectory) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length_m +=
        (trajectory[i].T_world_left.translation() - trajectory[i - 1].T_world_left.translation()).norm();
  }
  return length_m;
}

Rows FigureRows(const ReplayResult& result) {
  const ReplayStats& stats = result.stats;
  Rows rows = {
      {"frames", Printed("%lld, %lld tracked, %lld dropped", static_cast<long long>(stats.frames),
                         static_cast<long long>(stats.tracked), static_cast<long long>(stats.dropped))},
      {"way", Printed("%.2f m", LengthOf(result.trajectory))},
      {"rate", Printed("%.1f frames/s", stats.rate_hz)},
      {"up from",
       Printed("%s, +- %.2f deg", Name(stats.gravity.source), stats.gravity.sigma_rad * 57.29577951308232)},
      {"memory", Printed("%.0f MiB at most", stats.peak_rss_mib)},
      {"map", Printed("%lld cells, %zu regions, %zu staircase%s", static_cast<long long>(stats.map_cells),
                      result.map.regions.size(), result.map.staircases.size(),
                      result.map.staircases.size() == 1 ? "" : "s")}};
  if (stats.latency) {
    rows.emplace_back("image to map",
                      Printed("%.0f ms (99 %%: %.0f)", stats.latency->p50, stats.latency->p99));
  }
  return rows;
}

nlohmann::json PicturesJson(const std::vector<ViewPicture>& pictures) {
  nlohmann::json list = nlohmann::json::array();
  for (const ViewPicture& picture : pictures) {
    list.push_back(
        {{"caption", picture.caption}, {"utime", picture.t_capture.utime()}, {"jpeg", Base64(picture.jpeg)}});
  }
  return list;
}

ViewBytes FiguresRecord(const ReplayResult& result, const ViewBeside& beside) {
  Rows rows = FigureRows(result);
  rows.insert(rows.end(), beside.rows.begin(), beside.rows.end());
  nlohmann::json stages = nlohmann::json::array();
  for (const auto& [name, times] : result.stats.StagesInOrder()) {
    stages.push_back(
        {{"name", name}, {"p50_ms", times.p50_ms}, {"p99_ms", times.p99_ms}, {"cpu_ms", times.cpu_ms_mean}});
  }
  const nlohmann::json json = {
      {"title", "Replay"}, {"rows", rows}, {"stages", stages}, {"images", PicturesJson(beside.pictures)}};
  return MakeViewRecord(ViewRecordKind::kFigures, {}, json.dump());
}

ViewBytes PoseRecord(const ResultFrame& frame, const ResultPose* pose, const ReplayResult& result) {
  PoseEstimate estimate;
  estimate.t_capture = frame.t_capture;
  estimate.status = pose ? frame.status : TrackingStatus::kLost;
  estimate.reason = frame.reason;
  estimate.epoch = frame.epoch;
  if (pose) estimate.T_world_left = pose->T_world_left;
  if (frame.covariance) estimate.covariance = *frame.covariance;
  const Eigen::Isometry3d T_body_left = result.camera.T_body_left.value_or(Eigen::Isometry3d::Identity());
  return MakeViewRecord(ViewRecordKind::kPose, frame.t_capture, {},
                        ToMessage(BodyPoseOf(estimate, T_body_left, std::nullopt, result.map.map_id)));
}

/// What of a result's map had been seen first by then; staircases as they were reported then.
TerrainMapPtr MapUntil(Timestamp t, const ReplayResult& result, const Eigen::Isometry3d& T_world_left,
                       std::int64_t seq) {
  auto map = std::make_shared<TerrainMap>(result.map);
  map->t_capture = t;
  map->seq = seq;
  map->T_world_left = T_world_left;
  map->T_body_left = result.camera.T_body_left;
  map->gravity = result.stats.gravity;
  std::erase_if(map->regions, [&](const auto& region) { return region->first_seen > t; });
  std::map<std::int64_t, const Staircase*> reported;
  for (const StaircaseReport& report : result.staircase_reports) {
    if (report.t_capture <= t) reported[report.staircase.id] = &report.staircase;
  }
  std::erase_if(map->staircases, [&](const Staircase& stairs) { return !reported.contains(stairs.id); });
  for (Staircase& stairs : map->staircases) stairs = *reported[stairs.id];
  return map;
}

}  // namespace

std::vector<ViewBytes> RecordsOfMap(const std::filesystem::path& file) {
  const auto map = std::make_shared<const TerrainMap>(ReadTerrainMapFile(file));
  ViewFeed feed({"map", file.filename().string()});
  feed.TakeMap(map, {});
  ViewCursor cursor(&feed);
  std::vector<ViewBytes> records;
  while (ViewBytes record = cursor.Next()) records.push_back(std::move(record));
  return records;
}

std::vector<ViewBytes> RecordsOfResult(const ReplayResult& result, const std::string& source,
                                       const ViewBeside& beside) {
  ViewFeed feed({source, NameOf(result.folder)});
  ViewCursor cursor(&feed);
  std::vector<ViewBytes> records = {FiguresRecord(result, beside), CameraRecord(result.camera.camera)};
  std::map<Timestamp, const ResultPose*> poses;
  for (const ResultPose& pose : result.trajectory) poses[pose.t_capture] = &pose;
  std::set<Timestamp> changes;  // when a region or a staircase came
  for (const auto& region : result.map.regions) changes.insert(region->first_seen);
  for (const StaircaseReport& report : result.staircase_reports) changes.insert(report.t_capture);

  Timestamp t_before{-1};
  std::int64_t seq = 0;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  for (const ResultFrame& frame : result.frames) {
    const auto pose = poses.find(frame.t_capture);
    if (pose != poses.end()) T_world_left = pose->second->T_world_left;
    records.push_back(PoseRecord(frame, pose == poses.end() ? nullptr : pose->second, result));
    const auto first = changes.upper_bound(t_before);
    const bool last = &frame == &result.frames.back();
    if (last || (first != changes.end() && *first <= frame.t_capture)) {
      // The map at the end is whole, whatever the times in it say.
      const Timestamp t = last ? std::max(frame.t_capture, result.map.t_capture) : frame.t_capture;
      feed.TakeMap(MapUntil(t, result, T_world_left, ++seq), {});
    }
    while (ViewBytes record = cursor.Next()) records.push_back(std::move(record));
    t_before = frame.t_capture;
  }
  return records;
}

}  // namespace terrace
