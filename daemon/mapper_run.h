// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "client/terrace_file.h"
#include "core/camera.h"
#include "core/sensor_frame.h"
#include "daemon/frame_sink.h"
#include "daemon/handover_times.h"
#include "daemon/loaded_map.h"
#include "daemon/pipeline.h"
#include "daemon/threaded_pipeline.h"
#include "daemon/view_keeper.h"

namespace terrace {

/// A mapper at work on frames from anywhere: pipeline, threads and sinks. Replay and live differ in where
/// frames come from, in their pace and in the list of sinks.
class MapperRun {
 public:
  /// @param single_threaded  frames are worked on one after the other inside Push; only at Pace::kEveryFrame
  MapperRun(const PipelineConfig& config, const StereoCalibration& calibration, Pace pace,
            bool single_threaded);

  Pipeline& pipeline() { return pipeline_; }
  /// A map from a file beside the one that is made; sinks see both as one. From any thread.
  LoadedMap& loaded_map() { return loaded_map_; }
  /// Before the first frame. Sinks are called in the order in which they were added.
  template <typename Sink>
  Sink* Add(std::unique_ptr<Sink> sink) {
    Sink* const added = sink.get();
    sinks_.push_back(std::move(sink));
    return added;
  }

  /// Keeps views by which places are recognised, for saved_map(): a few milliseconds for each new place.
  /// Before the first frame.
  void KeepViews() { keeps_views_ = true; }

  /// Hands a frame over. False when a stage has failed: Finish() throws why.
  bool Push(SensorFrame sensors);
  /// Waits for what is under way and ends the sinks. Throws what a stage threw.
  /// @param num_lost_before  frames that were lost before they could be handed over
  void Finish(std::int64_t num_lost_before);

  /// As the last frame left it; null before the first one. From any thread.
  TerrainMapPtr map() const;
  /// The same, with the views by which its places can be recognised, where they are kept; without a map
  /// before the first frame. From any thread.
  SavedMap saved_map() const;
  /// Why the region or staircase of map() with this id is what it is. From any thread.
  Explanations Explain(std::int64_t id) const;
  FlowCounts counts() const { return threads_ ? threads_->counts() : FlowCounts{}; }

 private:
  void TakePose(const PoseEstimate& pose);
  void TakeFrame(FrameResult result);
  void KeepView(const FrameResult& result);

  const Pace pace_;
  const bool single_threaded_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  Pipeline pipeline_;
  LoadedMap loaded_map_;
  std::vector<std::unique_ptr<FrameSink>> sinks_;
  HandoverTimes handovers_;
  FrameId next_frame_id_ = 0;  // of a single thread
  mutable std::mutex mutex_;
  TerrainMapPtr map_;
  bool keeps_views_ = false;
  ViewKeeper views_;
  std::int64_t views_map_id_ = 0;            // of the mapper's own map
  std::optional<ThreadedPipeline> threads_;  // last: its threads use everything above
};

}  // namespace terrace
