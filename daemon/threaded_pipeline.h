// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "core/bounded_queue.h"
#include "core/sensor_frame.h"
#include "core/stage.h"
#include "daemon/pipeline.h"

namespace terrace {

/// The steps of a Pipeline on threads: rectification, then disparity and odometry side by side, then the map,
/// each at work on another frame. The results are those of Pipeline::Process, in the same order.
class ThreadedPipeline {
 public:
  /// Receives each frame, in order, in the thread of the map. Reading from `sensors`: what entered.
  using Sink = std::function<void(const SensorFrame& sensors, const FrameResult& result)>;

  /// @param when_full  kWait: Push waits and nothing is lost; kDropOldest: the newest frame wins, its
  /// forerunners'
  ///                   samples go to it, and drops are counted
  ThreadedPipeline(Pipeline* pipeline, WhenFull when_full, Sink sink);
  ~ThreadedPipeline();

  /// Hands a frame over; its frame_id is set here. False when the pipeline has ended.
  bool Push(SensorFrame sensors);
  /// Waits until all frames are through; throws what a step threw.
  void Finish();

  std::int64_t num_dropped() const { return input_.num_dropped(); }
  std::size_t queue_depth() const { return input_.size(); }

 private:
  using SensorFramePtr = std::shared_ptr<const SensorFrame>;
  struct Rectified {
    SensorFramePtr sensors;
    StereoFramePtr frame;
  };
  struct Tracked {
    SensorFramePtr sensors;
    TrackedPose pose;
  };

  void CloseAll();

  Pipeline* const pipeline_;
  const Sink sink_;
  FrameId next_frame_id_ = 0;  // of the rectifying thread
  BoundedQueue<SensorFrame> input_;
  BoundedQueue<StereoFramePtr> to_match_{2, WhenFull::kWait};
  BoundedQueue<Rectified> to_track_{2, WhenFull::kWait};
  BoundedQueue<std::shared_ptr<const DisparityImage>> to_map_{2, WhenFull::kWait};
  BoundedQueue<Tracked> poses_{2, WhenFull::kWait};
  Stage<SensorFrame> rectify_;
  Stage<StereoFramePtr> match_;
  Stage<Rectified> track_;
  Stage<std::shared_ptr<const DisparityImage>> map_;
};

}  // namespace terrace
