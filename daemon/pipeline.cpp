// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline.h"

#include <algorithm>
#include <utility>

#include "core/check.h"
#include "labeling/gravity_from_planes.h"
#include "stereo/cloud.h"

namespace terrace {
namespace {

Mounting MountingOf(const StereoCalibration& calibration, const Eigen::Matrix3d& R_rect_raw) {
  Mounting mounting;
  mounting.imu_noise = calibration.imu_noise;
  if (!calibration.T_body_rawleft) return mounting;
  Eigen::Isometry3d T_rawleft_left = Eigen::Isometry3d::Identity();
  T_rawleft_left.linear() = R_rect_raw.transpose();
  mounting.T_body_left = *calibration.T_body_rawleft * T_rawleft_left;
  if (calibration.T_body_imu) mounting.T_left_imu = mounting.T_body_left->inverse() * *calibration.T_body_imu;
  return mounting;
}

/// Ids of regions that are new or have another revision in `after`, and of those that are gone. Both maps
/// ascend by id.
void CompareMaps(const TerrainMap& before, const TerrainMap& after, FrameResult* result) {
  auto old = before.regions.begin();
  for (const auto& region : after.regions) {
    for (; old != before.regions.end() && (*old)->id < region->id; ++old)
      result->removed.push_back((*old)->id);
    const bool known = old != before.regions.end() && (*old)->id == region->id;
    if (!known || (*old)->revision != region->revision) result->changed.push_back(region->id);
    if (known) ++old;
  }
  for (; old != before.regions.end(); ++old) result->removed.push_back((*old)->id);
}

}  // namespace

std::vector<std::string> FlowConfig::Problems() const {
  std::vector<std::string> problems;
  if (feedback_lag_frames < 1 || feedback_lag_frames > 16) {
    problems.push_back("feedback_lag_frames = " + std::to_string(feedback_lag_frames) +
                       " must lie between 1 and 16");
  }
  return problems;
}

Pipeline::Pipeline(const PipelineConfig& config, const StereoCalibration& calibration,
                   const cv::Mat1b& self_mask)
    : config_(config),
      rectifier_(calibration, config.rectifier),
      mounting_(MountingOf(calibration, rectifier_.R_rect_raw())),
      self_mask_(self_mask),
      matcher_(config.stereo),
      odometry_(config.odometry, rectifier_.camera(), mounting_),
      modeller_(config.modelling),
      gravity_hints_(config.flow.feedback_lag_frames),
      disparity_priors_(config.flow.feedback_lag_frames) {
  TERRACE_CHECK(self_mask.empty() || (self_mask.cols == camera().width && self_mask.rows == camera().height),
                self_mask.cols, self_mask.rows);
  StartMap(1);
}

void Pipeline::StartMap(std::int64_t map_id) {
  octree_ = std::make_unique<TerrainOctree>(config_.mapping, camera());
  merger_ = std::make_unique<PolygonMerger>(config_.merging);
  labeler_ = std::make_unique<TerrainLabeler>(config_.labeling, config_.staircases, config_.robot, camera(),
                                              mounting_.T_body_left, map_id);
}

FrameResult Pipeline::Process(const SensorFrame& sensors) {
  const StereoFramePtr frame = Rectify(sensors);
  const auto disparity = Match(frame);
  const TrackedPose tracked = Track(sensors, frame);  // beside the matcher when threaded
  return Map(disparity, tracked);
}

StereoFramePtr Pipeline::Rectify(const SensorFrame& sensors) {
  if (!sensors.pair.problem.empty()) return nullptr;
  return meters_["rectify"].Run([&] {
    return std::make_shared<const StereoFrame>(rectifier_.Rectify(sensors.frame_id, sensors.pair));
  });
}

std::shared_ptr<const DisparityImage> Pipeline::Match(const StereoFramePtr& frame) {
  if (!frame) return nullptr;
  std::shared_ptr<const DisparityPrior> prior;
  if (config_.stereo.use_prior) prior = disparity_priors_.Take(frame->frame_id);
  return meters_["disparity"].Run(
      [&] { return std::make_shared<const DisparityImage>(matcher_.Match(*frame, prior.get())); });
}

TrackedPose Pipeline::Track(const SensorFrame& sensors, const StereoFramePtr& frame) {
  const std::optional<GravityHint> gravity_hint = gravity_hints_.Take(sensors.frame_id);
  return meters_["odometry"].Run([&] {
    if (gravity_hint) odometry_.Apply(*gravity_hint);
    const PoseEstimate pose = frame ? odometry_.Track(*frame, sensors.samples)
                                    : odometry_.Bridge(sensors.frame_id, sensors.pair.t_capture,
                                                       sensors.samples, sensors.pair.problem);
    const std::vector<std::string>& all = odometry_.warnings();
    std::vector<std::string> warnings(all.begin() + static_cast<std::ptrdiff_t>(num_warnings_), all.end());
    num_warnings_ = all.size();
    return TrackedPose{pose, odometry_.gravity(), odometry_.sightings(), frame, std::move(warnings)};
  });
}

FrameResult Pipeline::Map(const std::shared_ptr<const DisparityImage>& disparity,
                          const TrackedPose& tracked) {
  FrameResult result;
  result.pose = tracked.pose;
  result.frame = tracked.frame;
  result.disparity = disparity;
  result.sightings = tracked.sightings;
  result.warnings = tracked.warnings;
  const TerrainMapPtr before = labeler_->map();
  if (reset_requested_.exchange(false)) StartMap(before->map_id + 1);
  std::optional<GravityHint> gravity_hint;
  std::shared_ptr<const DisparityPrior> disparity_prior;
  // A pose that is bridged or in doubt is a guess: it tells the robot where it is, but nothing is built on
  // it.
  if (tracked.pose.status == TrackingStatus::kTracking && tracked.pose.reason.empty() && disparity) {
    const ChangedCells cells = meters_["decomposition"].Run([&] {
      if (config_.stereo.use_prior) disparity_prior = ExpectDisparities(*disparity, tracked.pose);
      const Cloud cloud = Triangulate(*disparity, camera(), config_.cloud, self_mask_);
      return octree_->Insert(cloud, tracked.pose);
    });
    const PatchUpdate patches = meters_["modelling"].Run([&] { return modeller_.Fit(*octree_, cells); });
    const PolygonUpdate polygons = meters_["merging"].Run([&] { return merger_->Merge(patches); });
    meters_["labels"].Run([&] { return labeler_->Label(polygons, tracked.pose, tracked.gravity); });
    gravity_hint = GravityFromPlanes(polygons, tracked.pose, tracked.gravity);
  }
  gravity_hints_.Post(tracked.pose.frame_id, gravity_hint);
  if (config_.stereo.use_prior) disparity_priors_.Post(tracked.pose.frame_id, std::move(disparity_prior));
  if (tracked.pose.status == TrackingStatus::kTracking) last_tracked_ = tracked.pose;

  result.map = labeler_->map();
  CompareMaps(*before, *result.map, &result);
  result.map_cells = octree_->num_occupied_leaves();
  result.map_bytes = octree_->memory_bytes() + merger_->memory_bytes();
  return result;
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
  gravity_hints_.Close();
  disparity_priors_.Close();
}

}  // namespace terrace
