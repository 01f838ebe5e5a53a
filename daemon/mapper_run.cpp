// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/mapper_run.h"

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "core/check.h"
#include "core/print.h"
#include "daemon/config.h"
#include "daemon/self_mask.h"
#include "stereo/image_scale.h"
#include "stereo/rectifier.h"

namespace terrace {
namespace {

/// Throws ConfigError where the region of interest reaches out of the image, whose size is only known now.
const PipelineConfig& WithinTheImage(const PipelineConfig& config, const StereoCalibration& calibration) {
  const auto [width, height] = RectifiedSize(Scaled(calibration, config.image_scale), config.rectifier);
  const DisparityConfig& stereo = config.stereo;
  for (const auto& [side, start, length_name, length, size] :
       {std::tuple{"left", stereo.roi_left_px, "width", stereo.roi_width_px, width},
        std::tuple{"top", stereo.roi_top_px, "height", stereo.roi_height_px, height}}) {
    if (start < size && start + length <= size) continue;
    throw ConfigError(
        Printed("stereo.roi_%s_px = %d, stereo.roi_%s_px = %d reach out of the rectified image, "
                "whose %s is %d",
                side, start, length_name, length, length_name, size));
  }
  return config;
}

}  // namespace

MapperRun::MapperRun(const PipelineConfig& config, const StereoCalibration& calibration, Pace pace,
                     bool single_threaded)
    : pace_(pace),
      single_threaded_(single_threaded),
      pipeline_(WithinTheImage(config, calibration), calibration, LoadSelfMask(config, calibration), pace),
      loaded_map_(pipeline_.camera(), pipeline_.T_body_left()),
      views_(pipeline_.camera()) {
  TERRACE_CHECK(pace == Pace::kEveryFrame || !single_threaded);
}

bool MapperRun::Push(SensorFrame sensors) {
  handovers_.Add(sensors.pair.t_capture);
  if (single_threaded_) {
    sensors.frame_id = next_frame_id_++;
    TakeFrame(pipeline_.Process(sensors, [this](const PoseEstimate& pose) { TakePose(pose); }));
    return true;
  }
  if (!threads_) {
    threads_.emplace(
        &pipeline_, pace_, [this](const PoseEstimate& pose) { TakePose(pose); },
        [this](FrameResult result) { TakeFrame(std::move(result)); });
  }
  return threads_->Push(std::move(sensors));
}

void MapperRun::Finish(std::int64_t num_lost_before) {
  if (threads_) threads_->Finish();
  RunTotals totals;
  totals.num_dropped = num_lost_before + counts().num_dropped;
  totals.num_passed_over = counts().num_passed_over;
  totals.num_lessons_skipped = pipeline_.num_lessons_skipped();
  totals.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  totals.realtime = pace_ == Pace::kNewest;
  totals.gravity = pipeline_.gravity();
  totals.stages = pipeline_.meters().costs();
  totals.explanations = loaded_map_.InJointIds(pipeline_.Explain());
  for (const auto& sink : sinks_) sink->Finish(totals);
}

TerrainMapPtr MapperRun::map() const {
  const std::lock_guard lock(mutex_);
  return map_;
}

SavedMap MapperRun::saved_map() const {
  std::vector<PlaceView> loaded = loaded_map_.ViewsInWorld();
  const std::lock_guard lock(mutex_);
  SavedMap saved{map_, views_.views()};
  const std::size_t num_own = saved.views.size();
  for (PlaceView& view : loaded) {
    const auto end = saved.views.begin() + static_cast<std::ptrdiff_t>(num_own);
    if (std::none_of(saved.views.begin(), end, [&](const PlaceView& own) {
          return AreNeighbours(own.T_world_left, view.T_world_left);
        }))
      saved.views.push_back(std::move(view));
  }
  return saved;
}

Explanations MapperRun::Explain(std::int64_t id) const {
  if (const std::optional<std::int64_t> own = loaded_map_.OwnId(id))
    return loaded_map_.InJointIds(pipeline_.Explain(*own));
  Explanations explanations;
  const TerrainMapPtr joint = map();
  const auto is_it = [&](const auto& region) { return region->id == id; };
  if (joint && std::any_of(joint->regions.begin(), joint->regions.end(), is_it)) {
    RegionExplanation& region = explanations.regions.emplace_back();
    region.id = id;
    region.text = "region " + std::to_string(id) + ": as it was in the file that was loaded; not seen since.";
  }
  return explanations;
}

void MapperRun::TakePose(const PoseEstimate& pose) {
  for (const auto& sink : sinks_) sink->AddPose(pose);
}

void MapperRun::TakeFrame(FrameResult result) {
  const StageMeasurement measuring(&pipeline_.meters(), StageId::kPublish);
  KeepView(result);
  result.change = loaded_map_.Join(result.change, result.pose, result.frame.get());
  if (pace_ == Pace::kNewest) result.latency_ms = handovers_.LatencyMs(result.pose.t_capture);
  for (const auto& sink : sinks_) sink->AddFrame(result);
  const std::lock_guard lock(mutex_);
  map_ = result.change.map;
}

/// Of the mapper's own map, before others are joined to it.
void MapperRun::KeepView(const FrameResult& result) {
  const std::lock_guard lock(mutex_);
  const TerrainMap& own = *result.change.map;
  if (std::exchange(views_map_id_, own.map_id) != own.map_id) views_.Clear();
  if (keeps_views_ && result.frame && result.pose.trusted && result.pose.reason.empty())
    views_.Add(*result.frame, result.pose);
}

}  // namespace terrace
