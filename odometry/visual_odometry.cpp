// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/visual_odometry.h"

#include <string>

#include "core/check.h"
#include "odometry/covariance.h"
#include "odometry/credible.h"
#include "odometry/visual_odometry_impl.h"

namespace terrace {

VisualOdometry::Impl::Impl(const OdometryConfig& config, const StereoCamera& camera, const Mounting& mounting)
    : config_(config),
      camera_(camera),
      mounting_(mounting),
      grid_(FeatureGrid::For(camera.width, camera.height, config.num_cells)),
      motion_(config, mounting),
      pose_finder_(camera, grid_, config.min_inliers),
      keyframe_policy_(config, camera, grid_),
      keyframe_maker_(camera, grid_, config.max_disparity_px),
      optimizer_(camera, std::nullopt),
      archive_(camera, config.archived_keyframes),
      gravity_(config, mounting),
      vertical_(config.max_vertical_disparity_px),
      columns_(camera),
      delay_(camera),
      torn_(camera, grid_) {}

PoseEstimate VisualOdometry::Impl::Track(const StereoFrame& frame, const SensorSamples& samples) {
  TERRACE_CHECK(frame.left.size() == cv::Size(camera_.width, camera_.height) &&
                frame.right.size() == frame.left.size());
  const ImagePyramid left = BuildPyramid(frame.left);
  const ImagePyramid right = BuildPyramid(frame.right);
  sightings_ = {};
  standing_.See(frame);
  if (!last_) return Start(frame, left, right, samples, {});

  if (frame.t_capture <= last_->t_capture) LoseTime(frame.t_capture);
  Read(samples, frame.t_capture);
  const Motion predicted = Predict(frame.t_capture);
  if (const std::string frozen = Frozen(predicted); !frozen.empty()) {
    PoseEstimate pose = Bridged(frame.frame_id, frame.t_capture, predicted, frozen);
    pose.reason_code = ReasonCode::kUnreadableImages;
    return pose;
  }
  const Expectation expected = Expected(frame, predicted);
  const auto found = pose_finder_.Find(window_, left, right, expected);
  if (!found || !CanHaveMovedTo(found->solution.T_world_left, predicted.dt_s))
    return Unfound(frame, left, right, samples, predicted);
  Witness::Verdict verdict = Hear(expected, predicted, found->solution.T_world_left);
  if (const auto problem = ImuProblem(expected, predicted, found->solution.T_world_left)) {
    RefuseImu(*problem);
    verdict = Witness::Verdict::kAgrees;
  }
  const bool in_doubt = verdict != Witness::Verdict::kAgrees;
  if (in_doubt && verdict != Witness::Verdict::kAgreesAgain && !WitnessIsWrong(verdict, predicted))
    return expected.lost ? BeginWithout(predicted, frame, left, right, samples)
                         : Contradicted(frame, predicted, found->solution.T_world_left);

  PoseEstimate pose = Tracked(frame, *found);
  if (in_doubt) Doubt(predicted, &pose);
  if (standing_.both()) AddUnseen(predicted, &pose);
  if (expected.lost) motion_.Lose();
  motion_.Correct(*last_, pose, predicted, window_.keyframes.back(), gravity_.gravity());
  if (!motion_.imu_in_use()) gravity_.FollowAttitude(samples, pose);
  for (const auto& warning : {motion_.legs().TakeWarning(), gravity_.TakeWarning()})
    if (warning) warnings_.push_back(*warning);
  if (const auto warning = vertical_.Update(found->matches, found->solution)) warnings_.push_back(*warning);
  WatchPair(*found, pose, predicted.dt_s);
  if (last_->status == TrackingStatus::kTracking)
    torn_.See(window_, left, right, *found, last_->T_world_left);
  CountFates(*found, window_);
  NoteSightings(*found, window_, sightings_);
  const double age_s = Seconds(last_->t_capture - window_.keyframes.back().t_capture);
  if (!in_doubt && !torn_.torn() && !OneImageIsOld() &&
      keyframe_policy_.Wants(window_, left, *found, motion_.imu_in_use(), age_s)) {
    AddKeyframe(frame, left, right, pose.T_world_left, *found);
    RefineWindow(&pose);
  }
  // Measured on walks with a camera that is a frame late: accelerations are wrong by a share of the gait's.
  constexpr double kUp_rad = 3.0 * M_PI / 180.0;
  if (PairInDoubt()) gravity_.Doubt(kUp_rad);
  Remember(pose);
  return pose;
}

PoseEstimate VisualOdometry::Impl::Bridge(FrameId frame_id, Timestamp t_capture, const SensorSamples& samples,
                                          const std::string& reason) {
  sightings_ = {};
  if (!last_) {
    PoseEstimate pose;
    pose.frame_id = frame_id;
    pose.t_capture = t_capture;
    pose.reason = reason;
    pose.reason_code = ReasonCode::kUnreadableImages;
    return pose;
  }
  if (t_capture <= last_->t_capture) LoseTime(t_capture);
  Read(samples, t_capture);
  PoseEstimate pose = Bridged(frame_id, t_capture, Predict(t_capture), reason);
  pose.reason_code = ReasonCode::kUnreadableImages;
  return pose;
}

SensorSamples VisualOdometry::Impl::Believable(const SensorSamples& samples) {
  const bool told = num_incredible_ > 0;
  SensorSamples credible = Credible(samples, &num_incredible_);
  if (!told && num_incredible_ > 0)
    warnings_.push_back(
        "a reading of the IMU, attitude or leg odometry is not finite or beyond what a sensor can measure: "
        "such readings are left out");
  return credible;
}

PoseEstimate VisualOdometry::Impl::Tracked(const StereoFrame& frame, const PoseFinder::Found& found) {
  const PoseSolution& solution = found.solution;
  PoseEstimate pose;
  pose.frame_id = frame.frame_id;
  pose.t_capture = frame.t_capture;
  pose.status = TrackingStatus::kTracking;
  pose.T_world_left = solution.T_world_left;
  pose.T_prev_left = last_->T_world_left.inverse() * pose.T_world_left;
  Matrix6d own = kCorrelation * Inverse(solution.information);
  if (found.doubt) {
    own += *found.doubt;
    pose.reason = "another motion explains nearly as much: something large moves through the view";
    pose.reason_code = ReasonCode::kAmbiguousMotion;
  }
  const bool bridged_before = last_->status != TrackingStatus::kTracking;
  pose.covariance_prev =
      own + TransportCovariance(pose.T_prev_left, bridged_before ? last_->covariance : own_covariance_);
  own_covariance_ = own;
  const Eigen::Isometry3d T_keyframe_left =
      window_.keyframes.back().T_world_left.inverse() * pose.T_world_left;
  pose.covariance = TransportCovariance(T_keyframe_left, keyframe_covariance_) + own;
  pose.num_matches = static_cast<int>(found.matches.size());
  pose.num_inliers = solution.num_inliers;
  pose.rms_px = solution.rms_px;
  pose.vertical_disparity_px = vertical_.vertical_px();
  num_strange_frames_ = 0;
  return pose;
}

void VisualOdometry::Impl::Remember(const PoseEstimate& pose) {
  last_ = pose;
  if (pose.status != TrackingStatus::kTracking) return;
  bridging_.See(pose);
  contested_.setZero();
}

VisualOdometry::VisualOdometry(const OdometryConfig& config, const StereoCamera& camera,
                               const Mounting& mounting)
    : impl_(std::make_unique<Impl>(config, camera, mounting)) {}
VisualOdometry::~VisualOdometry() = default;

PoseEstimate VisualOdometry::Track(const StereoFrame& frame, const SensorSamples& samples) {
  return impl_->Published(impl_->Track(frame, impl_->Believable(samples)));
}
PoseEstimate VisualOdometry::Bridge(FrameId frame_id, Timestamp t_capture, const SensorSamples& samples,
                                    const std::string& reason) {
  return impl_->Published(impl_->Bridge(frame_id, t_capture, impl_->Believable(samples), reason));
}
const Gravity& VisualOdometry::gravity() const { return impl_->gravity(); }
const FrameSightings& VisualOdometry::sightings() const { return impl_->sightings(); }
const std::vector<std::string>& VisualOdometry::warnings() const { return impl_->warnings(); }
bool VisualOdometry::pair_was_never_right() const { return impl_->pair_was_never_right(); }
void VisualOdometry::Apply(const GravityHint& hint) { impl_->Apply(hint); }
void VisualOdometry::Hear(const PairTrouble& trouble) { impl_->HearOfPair(trouble); }

}  // namespace terrace
