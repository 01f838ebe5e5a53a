// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera.h"
#include "core/explanation.h"
#include "core/landmark_sightings.h"
#include "core/map_change.h"
#include "core/pose_estimate.h"
#include "core/sensor_frame.h"
#include "core/stage_meter.h"
#include "daemon/feedback.h"
#include "daemon/pipeline_config.h"
#include "odometry/visual_odometry.h"
#include "stereo/disparity_matcher.h"
#include "stereo/pair_monitor.h"
#include "stereo/rectifier.h"
#include "stereo/stereo_frame.h"
#include "terrain/terrain_mapper.h"

namespace terrace {

/// A pose with the direction of gravity as it was known at that frame.
struct TrackedPose {
  PoseEstimate pose;
  Gravity gravity;
  FrameSightings sightings;
  StereoFramePtr frame;               ///< that was tracked in; null when the images could not be used
  std::vector<std::string> warnings;  ///< new with this frame, a sentence each
  bool mapped_wrongly = false;        ///< so far, by what the odometry has found out about the pair
};

/// Which frames are mapped, and who waits for whom.
enum class Pace {
  kEveryFrame,  ///< all of them; stages wait for one another, and the map is the same for any number of
                ///< threads
  kNewest,      ///< the newest that there is time for; the pose waits for nobody
};

/// What one frame led to.
struct FrameResult {
  PoseEstimate pose;                                ///< always, also when lost
  MapChange change;                                 ///< with the map after the frame
  StereoFramePtr frame;                             ///< rectified; null when the images could not be used
  std::shared_ptr<const DisparityImage> disparity;  ///< likewise
  FrameSightings sightings;                         ///< landmarks of the odometry
  std::vector<std::string> warnings;                ///< for the user, new with this frame, a sentence each
  std::optional<double> latency_ms;  ///< from being handed over to the map being there; only at Pace::kNewest
};

/// The stages of the mapper, bound to one camera. Process() is the way of a frame; ThreadedPipeline binds the
/// four public steps to threads instead, with the same result.
class Pipeline {
 public:
  /// @param self_mask  CV_8UC1 of the rectified left image's size, 0 where the robot sees itself; empty: none
  Pipeline(const PipelineConfig& config, const StereoCalibration& calibration, const cv::Mat1b& self_mask,
           Pace pace = Pace::kEveryFrame);

  /// @param on_pose  called as soon as the pose is known
  FrameResult Process(const SensorFrame& sensors,
                      const std::function<void(const PoseEstimate&)>& on_pose = {});

  /// The rectified pair; null when the images cannot be used.
  StereoFramePtr Rectify(const SensorFrame& sensors);
  /// Null when there is no frame.
  std::shared_ptr<const DisparityImage> Match(const StereoFramePtr& frame);
  TrackedPose Track(const SensorFrame& sensors, const StereoFramePtr& frame);
  /// @param disparity  null: the frame is not mapped
  FrameResult Map(const std::shared_ptr<const DisparityImage>& disparity, const TrackedPose& tracked);

  /// Starts the map anew with the next frame; the odometry and the world frame go on. From any thread.
  void RequestMapReset() { reset_requested_ = true; }
  /// While the map is paused, frames have a pose but are not mapped. From any thread.
  void PauseMap(bool paused) { map_paused_ = paused; }

  /// Why regions and staircases of the map are what they are; waits while a frame is mapped. From any thread.
  /// @param only  the id of one region or staircase (either may have it); none: all
  Explanations Explain(const std::optional<std::int64_t>& only = std::nullopt) const;

  const StereoCamera& camera() const { return rectifier_.camera(); }
  const Eigen::Matrix3d& R_rect_raw() const { return rectifier_.R_rect_raw(); }
  const std::optional<Eigen::Isometry3d>& T_body_left() const { return mounting_.T_body_left; }
  const Gravity& gravity() const { return odometry_.gravity(); }
  /// For the thread that maps, between two frames.
  const TerrainOctree& octree() const { return mapper_.octree(); }
  StageMeters& meters() { return meters_; }
  /// What the map had learnt and an earlier stage did not wait for; always 0 at Pace::kEveryFrame.
  std::int64_t num_lessons_skipped() const {
    return odometry_lessons_.num_skipped() + disparity_priors_.num_skipped();
  }
  /// No step is left waiting for what a later one learns.
  void CloseFeedback();

 private:
  /// Of the frame that will use it; null where the motion is not known.
  std::shared_ptr<const DisparityPrior> ExpectDisparities(const DisparityImage& disparity,
                                                          const PoseEstimate& pose) const;
  /// What the odometry is taught.
  struct OdometryLesson {
    std::optional<GravityHint> gravity_hint;
    PairTrouble pair_trouble;
  };
  using PairFindings = std::array<bool, 10>;

  /// Why the images cannot be what a pair sees; empty: they can. Tells the user when that changes.
  std::string CheckPair(const StereoFrame& frame, const DisparityImage& disparity,
                        std::vector<std::string>* warnings);
  void PostLessons(const DisparityImage* disparity, const TrackedPose& tracked, bool mapped);

  PipelineConfig config_;
  StageMeters meters_;
  Rectifier rectifier_;
  Mounting mounting_;
  cv::Mat1b self_mask_;
  DisparityMatcher matcher_;
  VisualOdometry odometry_;
  mutable std::mutex mapper_mutex_;  // held while the map changes or is asked
  TerrainMapper mapper_;
  std::size_t num_warnings_ = 0;  // of the odometry, given out so far; of the thread that tracks
  FeedbackExchange<std::optional<OdometryLesson>> odometry_lessons_;
  FeedbackExchange<std::shared_ptr<const DisparityPrior>> disparity_priors_;  // only with stereo.use_prior
  std::optional<PoseEstimate> last_tracked_;                                  // of the thread that maps
  int epoch_ = 0;  // of the thread that maps, like what follows
  bool mapped_wrongly_ = false;
  PairMonitor pair_monitor_;
  PairFindings pair_findings_{};
  PairTrouble pair_trouble_;  ///< by the last frame that was compared
  std::atomic<bool> reset_requested_{false};
  std::atomic<bool> map_paused_{false};
};

}  // namespace terrace
