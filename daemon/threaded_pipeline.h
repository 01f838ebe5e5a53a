// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "core/bounded_queue.h"
#include "core/sensor_frame.h"
#include "core/stage.h"
#include "daemon/pipeline.h"

namespace terrace {

/// The samples of a frame that is dropped go in front of those of the next one: IMU and legs know no drops.
void SaveSamples(SensorFrame dropped, SensorFrame* next);

/// What did not go all the way, and what waits.
struct FlowCounts {
  std::int64_t num_dropped = 0;      ///< frames that came in while the odometry was behind: they have no pose
  std::int64_t num_passed_over = 0;  ///< frames with a pose that the map took no time for
  int num_waiting = 0;               ///< for the odometry
  int num_waiting_for_map = 0;
};

/// The steps of a Pipeline on threads: rectification, then disparity and odometry side by side, then the map,
/// each at work on another frame.
///
/// At Pace::kEveryFrame the results are those of Pipeline::Process. At Pace::kNewest every frame has a pose,
/// which leaves as soon as it is known; the map takes the newest frame that it can.
class ThreadedPipeline {
 public:
  /// Receives each pose, in order, in the thread of the odometry.
  using PoseSink = std::function<void(const PoseEstimate& pose)>;
  /// Receives each frame, in order, in the thread of the map.
  using FrameSink = std::function<void(FrameResult result)>;

  ThreadedPipeline(Pipeline* pipeline, Pace pace, PoseSink on_pose, FrameSink on_frame);
  ~ThreadedPipeline();

  /// Hands a frame over; its frame_id is set here. False when the pipeline has ended.
  bool Push(SensorFrame sensors);
  /// Waits until all frames are through; throws what a step threw.
  void Finish();

  FlowCounts counts() const;

 private:
  struct Rectified {
    std::shared_ptr<const SensorFrame> sensors;
    StereoFramePtr frame;
  };
  struct Matched {
    FrameId frame_id = 0;
    std::shared_ptr<const DisparityImage> disparity;
  };

  bool Rectify(SensorFrame sensors);
  bool Match(const Rectified& rectified);
  bool Track(const Rectified& rectified);
  bool Map(const Matched& matched);
  /// Frames with a pose before the given one, which the map will not come back to.
  bool PassOverBefore(FrameId frame_id);
  void CloseAll();

  Pipeline* const pipeline_;
  const Pace pace_;
  const PoseSink on_pose_;
  const FrameSink on_frame_;
  FrameId next_frame_id_ = 0;  // of the rectifying thread
  BoundedQueue<SensorFrame> input_;
  BoundedQueue<Rectified> to_match_;
  BoundedQueue<Rectified> to_track_;
  BoundedQueue<Matched> to_map_;
  BoundedQueue<TrackedPose> tracked_;
  std::optional<TrackedPose> next_tracked_;  // taken out of the queue by the thread of the map
  bool map_failed_ = false;                  // of the thread of the map
  std::atomic<std::int64_t> num_passed_over_{0};
  Stage<SensorFrame> rectify_;
  Stage<Rectified> match_;
  Stage<Rectified> track_;
  Stage<Matched> map_;
};

}  // namespace terrace
