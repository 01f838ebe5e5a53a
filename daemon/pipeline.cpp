// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/check.h"
#include "core/field_problems.h"

namespace terrace {
namespace {

/// The settings of the matcher for this camera; says what `auto` stands for.
DisparityConfig MatcherFor(const DisparityConfig& config, const StereoCamera& camera) {
  const DisparityConfig chosen = config.ForCamera(camera);
  if (!config.max_disparity_px)
    spdlog::info("stereo.max_disparity_px: auto searches {} px, which shows surfaces from {:.2f} m on",
                 *chosen.max_disparity_px, camera.Depth(*chosen.max_disparity_px));
  return chosen;
}

}  // namespace

std::vector<std::string> FlowConfig::Problems() const {
  FieldProblems problems;
  problems.RequireWithin("feedback_lag_frames", feedback_lag_frames, 1, 16);
  return problems.Take();
}

Pipeline::Pipeline(const PipelineConfig& config, const StereoCalibration& calibration,
                   const cv::Mat1b& self_mask, Pace pace)
    : config_(config),
      rectifier_(Scaled(calibration, config.image_scale), config.rectifier),
      mounting_(MountingOf(config.mounting, calibration, rectifier_.R_rect_raw())),
      self_mask_(self_mask),
      matcher_(MatcherFor(config.stereo, rectifier_.camera())),
      odometry_(config.odometry, rectifier_.camera(), mounting_),
      mapper_(config.terrain, rectifier_.camera(), mounting_.T_body_left, &meters_),
      odometry_lessons_(config.flow.feedback_lag_frames, pace == Pace::kEveryFrame),
      disparity_priors_(config.flow.feedback_lag_frames, pace == Pace::kEveryFrame) {
  TERRACE_CHECK(self_mask.empty() || (self_mask.cols == camera().width && self_mask.rows == camera().height),
                self_mask.cols, self_mask.rows);
  if (config.image_scale.scale != 1.0)
    spdlog::info("camera.scale: {} makes {}x{} of {}x{} pixels, with a focal length of {:.1f} px",
                 config.image_scale.scale, camera().width, camera().height, calibration.width,
                 calibration.height, camera().fx);
}

FrameResult Pipeline::Process(const SensorFrame& sensors,
                              const std::function<void(const PoseEstimate&)>& on_pose) {
  const StereoFramePtr frame = Rectify(sensors);
  const auto disparity = Match(frame);
  const TrackedPose tracked = Track(sensors, frame);  // beside the matcher when threaded
  if (on_pose) on_pose(tracked.pose);
  return Map(disparity, tracked);
}

StereoFramePtr Pipeline::Rectify(const SensorFrame& sensors) {
  if (!sensors.pair.problem.empty()) return nullptr;
  const StageMeasurement measuring(&meters_, StageId::kRectify);
  const ImageScaleConfig& scale = config_.image_scale;
  return std::make_shared<const StereoFrame>(
      scale.scale == 1.0 ? rectifier_.Rectify(sensors.frame_id, sensors.pair)
                         : rectifier_.Rectify(sensors.frame_id, Scaled(sensors.pair, scale)));
}

std::shared_ptr<const DisparityImage> Pipeline::Match(const StereoFramePtr& frame) {
  if (!frame) return nullptr;
  std::shared_ptr<const DisparityPrior> prior;
  if (config_.stereo.use_prior) prior = disparity_priors_.Take(frame->frame_id);
  const StageMeasurement measuring(&meters_, StageId::kDisparity);
  return std::make_shared<const DisparityImage>(matcher_.Match(*frame, prior.get()));
}

TrackedPose Pipeline::Track(const SensorFrame& sensors, const StereoFramePtr& frame) {
  const std::optional<OdometryLesson> lesson = odometry_lessons_.Take(sensors.frame_id);
  const StageMeasurement measuring(&meters_, StageId::kOdometry);
  if (lesson) {
    odometry_.Hear(lesson->pair_trouble);
    if (lesson->gravity_hint) odometry_.Apply(*lesson->gravity_hint);
  }
  const PoseEstimate pose = frame ? odometry_.Track(*frame, sensors.samples)
                                  : odometry_.Bridge(sensors.frame_id, sensors.pair.t_capture,
                                                     sensors.samples, sensors.pair.problem);
  const std::vector<std::string>& all = odometry_.warnings();
  std::vector<std::string> warnings(all.begin() + static_cast<std::ptrdiff_t>(num_warnings_), all.end());
  num_warnings_ = all.size();
  return {pose,  odometry_.gravity(), odometry_.sightings(),
          frame, std::move(warnings), odometry_.pair_was_never_right()};
}

FrameResult Pipeline::Map(const std::shared_ptr<const DisparityImage>& disparity,
                          const TrackedPose& tracked) {
  const std::lock_guard lock(mapper_mutex_);
  // The map of another world has no place in this one.
  const bool new_world = std::exchange(epoch_, tracked.pose.epoch) != tracked.pose.epoch;
  // What was mapped with a pair that has turned out to be wrong is wrong from the beginning.
  const bool found_bad = !std::exchange(mapped_wrongly_, tracked.mapped_wrongly) && tracked.mapped_wrongly;
  if (reset_requested_.exchange(false) || new_world || found_bad) mapper_.Reset();
  // A pose that is bridged or in doubt is a guess: it tells the robot where it is, but nothing is built on
  // it.
  FrameResult result;
  result.warnings = tracked.warnings;
  const std::string unsound = disparity ? CheckPair(*tracked.frame, *disparity, &result.warnings) : "";
  const bool mapped = tracked.pose.trusted && disparity && unsound.empty() && !map_paused_;
  result.pose = tracked.pose;
  if (result.pose.reason.empty()) result.pose.reason = unsound;
  result.change = mapped ? mapper_.Update({*disparity, camera(), self_mask_}, tracked.pose, tracked.gravity)
                         : mapper_.Unchanged();
  if (mapped)
    result.warnings.insert(result.warnings.end(), mapper_.warnings().begin(), mapper_.warnings().end());
  result.frame = tracked.frame;
  result.disparity = disparity;
  result.sightings = tracked.sightings;
  PostLessons(disparity.get(), tracked, mapped);
  return result;
}

std::string Pipeline::CheckPair(const StereoFrame& frame, const DisparityImage& disparity,
                                std::vector<std::string>* warnings) {
  const PairHealth health = pair_monitor_.Check(frame, disparity);
  const PairFindings findings{health.left_blank,  health.right_blank,  health.half_blank, health.different,
                              health.left_stands, health.right_stands, health.both_stand, health.rows_off,
                              health.warped,      health.not_at_once};
  if (std::exchange(pair_findings_, findings) != findings) {
    const std::string reason = health.Reason();
    warnings->push_back(reason.empty() ? "the two cameras show the same again" : reason);
  }
  pair_trouble_ = {};
  if (health.misplaces())
    pair_trouble_ = {health.Reason(),
                     health.warped ? ReasonCode::kBadCalibration : ReasonCode::kInputTrouble};
  return health.stops_mapping() ? health.Reason() : "";
}

Explanations Pipeline::Explain(const std::optional<std::int64_t>& only) const {
  const std::lock_guard lock(mapper_mutex_);
  return mapper_.Explain(only);
}

void Pipeline::PostLessons(const DisparityImage* disparity, const TrackedPose& tracked, bool mapped) {
  odometry_lessons_.Post(tracked.pose.frame_id,
                         OdometryLesson{mapped ? mapper_.gravity_hint() : std::nullopt, pair_trouble_});
  if (config_.stereo.use_prior)
    disparity_priors_.Post(tracked.pose.frame_id,
                           mapped ? ExpectDisparities(*disparity, tracked.pose) : nullptr);
  if (tracked.pose.status == TrackingStatus::kTracking) last_tracked_ = tracked.pose;
}

std::shared_ptr<const DisparityPrior> Pipeline::ExpectDisparities(const DisparityImage& disparity,
                                                                  const PoseEstimate& pose) const {
  if (!last_tracked_ || last_tracked_->frame_id + 1 != pose.frame_id) return nullptr;
  // As the camera has moved since the frame before, so it will go on.
  const Eigen::Isometry3d T_next_now = pose.T_world_left.inverse() * last_tracked_->T_world_left;
  Eigen::Isometry3d T_then_now = T_next_now;
  for (int i = 1; i < config_.flow.feedback_lag_frames; ++i) T_then_now = T_then_now * T_next_now;
  return std::make_shared<const DisparityPrior>(PredictDisparities(disparity, camera(), T_then_now));
}

void Pipeline::CloseFeedback() {
  odometry_lessons_.Close();
  disparity_priors_.Close();
}

}  // namespace terrace
