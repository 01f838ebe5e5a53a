// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threaded_pipeline.h"

#include <exception>
#include <limits>
#include <utility>

#include "daemon/thread_priority.h"

namespace terrace {
namespace {

// Poses that may wait for the map; a map that is farther behind holds the odometry up.
constexpr std::size_t kWaitingPoses = 1024;

WhenFull WhenFullAt(Pace pace) { return pace == Pace::kEveryFrame ? WhenFull::kWait : WhenFull::kDropOldest; }

}  // namespace

void SaveSamples(SensorFrame dropped, SensorFrame* next) {
  const auto prepend = [](auto& earlier, auto& later) {
    earlier.insert(earlier.end(), later.begin(), later.end());
    later = std::move(earlier);
  };
  prepend(dropped.samples.imu, next->samples.imu);
  prepend(dropped.samples.priors, next->samples.priors);
}

ThreadedPipeline::ThreadedPipeline(Pipeline* pipeline, Pace pace, PoseSink on_pose, FrameSink on_frame)
    : pipeline_(pipeline),
      pace_(pace),
      on_pose_(std::move(on_pose)),
      on_frame_(std::move(on_frame)),
      input_(2, WhenFullAt(pace), SaveSamples),
      to_match_(pace == Pace::kEveryFrame ? 2 : 1, WhenFullAt(pace)),
      to_track_(2, WhenFull::kWait),
      to_map_(pace == Pace::kEveryFrame ? 2 : 1, WhenFullAt(pace)),
      tracked_(pace == Pace::kEveryFrame ? 2 : kWaitingPoses, WhenFull::kWait),
      rectify_(
          &input_, [this](SensorFrame sensors) { return Rectify(std::move(sensors)); },
          [this] {
            to_match_.Close();
            to_track_.Close();
          }),
      match_(
          &to_match_, [this](const Rectified& rectified) { return Match(rectified); },
          [this] { to_map_.Close(); }),
      track_(
          &to_track_, [this](const Rectified& rectified) { return Track(rectified); },
          [this] { tracked_.Close(); }),
      map_(
          &to_map_, [this](const Matched& matched) { return Map(matched); },
          [this] {
            // Nobody before the map may be left waiting for it; poses that are still to come wait for
            // Finish().
            if (pace_ == Pace::kEveryFrame || map_failed_) CloseAll();
          }) {}

ThreadedPipeline::~ThreadedPipeline() { CloseAll(); }

bool ThreadedPipeline::Rectify(SensorFrame sensors) {
  sensors.frame_id = next_frame_id_++;
  Rectified rectified;
  rectified.sensors = std::make_shared<const SensorFrame>(std::move(sensors));
  rectified.frame = pipeline_->Rectify(*rectified.sensors);
  // A frame without images has no disparity, and must not push one out that has.
  const bool has_map = rectified.frame || pace_ == Pace::kEveryFrame;
  return (!has_map || to_match_.Push(rectified)) && to_track_.Push(rectified);
}

bool ThreadedPipeline::Match(const Rectified& rectified) {
  if (pace_ == Pace::kNewest) YieldToThePose();
  return to_map_.Push({rectified.sensors->frame_id, pipeline_->Match(rectified.frame)});
}

bool ThreadedPipeline::Track(const Rectified& rectified) {
  TrackedPose tracked = pipeline_->Track(*rectified.sensors, rectified.frame);
  on_pose_(tracked.pose);
  return tracked_.Push(std::move(tracked));
}

bool ThreadedPipeline::Map(const Matched& matched) {
  if (pace_ == Pace::kNewest) YieldToThePose();
  map_failed_ = true;                                   // unless this gets to its end
  if (!PassOverBefore(matched.frame_id)) return false;  // the odometry has failed
  on_frame_(pipeline_->Map(matched.disparity, *std::exchange(next_tracked_, std::nullopt)));
  map_failed_ = false;
  return true;
}

bool ThreadedPipeline::PassOverBefore(FrameId frame_id) {
  for (;;) {
    if (!next_tracked_) next_tracked_ = tracked_.Pop();
    if (!next_tracked_) return false;
    if (next_tracked_->pose.frame_id >= frame_id) return true;
    ++num_passed_over_;
    on_frame_(pipeline_->Map(nullptr, *std::exchange(next_tracked_, std::nullopt)));
  }
}

void ThreadedPipeline::CloseAll() {
  input_.Close();
  to_match_.Close();
  to_track_.Close();
  to_map_.Close();
  tracked_.Close();
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
  PassOverBefore(std::numeric_limits<FrameId>::max());
}

FlowCounts ThreadedPipeline::counts() const {
  return {input_.num_dropped(), num_passed_over_, static_cast<int>(input_.size() + to_track_.size()),
          static_cast<int>(tracked_.size())};
}

}  // namespace terrace
