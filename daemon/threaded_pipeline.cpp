// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threaded_pipeline.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace terrace {
namespace {

/// The samples of a frame that is dropped go in front of those of the next one: IMU and legs know no drops.
void SaveSamples(SensorFrame dropped, SensorFrame* next) {
  const auto prepend = [](auto& earlier, auto& later) {
    earlier.insert(earlier.end(), later.begin(), later.end());
    later = std::move(earlier);
  };
  prepend(dropped.samples.imu, next->samples.imu);
  prepend(dropped.samples.priors, next->samples.priors);
}

}  // namespace

ThreadedPipeline::ThreadedPipeline(Pipeline* pipeline, WhenFull when_full, Sink sink)
    : pipeline_(pipeline),
      sink_(std::move(sink)),
      input_(2, when_full, SaveSamples),
      rectify_(
          &input_,
          [this](SensorFrame sensors) {
            sensors.frame_id = next_frame_id_++;
            const auto shared = std::make_shared<const SensorFrame>(std::move(sensors));
            const StereoFramePtr frame = pipeline_->Rectify(*shared);
            return to_match_.Push(frame) && to_track_.Push({shared, frame});
          },
          [this] {
            to_match_.Close();
            to_track_.Close();
          }),
      match_(
          &to_match_, [this](const StereoFramePtr& frame) { return to_map_.Push(pipeline_->Match(frame)); },
          [this] { to_map_.Close(); }),
      track_(
          &to_track_,
          [this](const Rectified& rectified) {
            return poses_.Push({rectified.sensors, pipeline_->Track(*rectified.sensors, rectified.frame)});
          },
          [this] { poses_.Close(); }),
      map_(
          &to_map_,
          [this](const std::shared_ptr<const DisparityImage>& disparity) {
            const std::optional<Tracked> tracked = poses_.Pop();
            if (!tracked) return false;  // the odometry has failed
            sink_(*tracked->sensors, pipeline_->Map(disparity, tracked->pose));
            return true;
          },
          // Whatever ended the map, nobody before it may be left waiting for it.
          [this] { CloseAll(); }) {}

ThreadedPipeline::~ThreadedPipeline() { CloseAll(); }

void ThreadedPipeline::CloseAll() {
  input_.Close();
  to_match_.Close();
  to_track_.Close();
  to_map_.Close();
  poses_.Close();
  pipeline_->CloseFeedback();
}

bool ThreadedPipeline::Push(SensorFrame sensors) { return input_.Push(std::move(sensors)); }

void ThreadedPipeline::Finish() {
  input_.Close();
  // Every stage is joined before the first failure is thrown: later ones often fail because of it.
  std::exception_ptr failure;
  const auto join = [&failure](auto& stage) {
    try {
      stage.Join();
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  };
  join(rectify_);
  join(match_);
  join(track_);
  join(map_);
  if (failure) std::rethrow_exception(failure);
}

}  // namespace terrace
