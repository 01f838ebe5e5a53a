// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/visual_odometry.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/check.h"
#include "odometry/bridging.h"
#include "odometry/covariance.h"
#include "odometry/image_pyramid.h"
#include "odometry/keyframe_archive.h"
#include "odometry/keyframe_maker.h"
#include "odometry/keyframe_policy.h"
#include "odometry/motion_model.h"
#include "odometry/pose_finder.h"
#include "odometry/rotation.h"
#include "odometry/vertical_monitor.h"
#include "odometry/window.h"
#include "odometry/window_optimizer.h"
#include "odometry/world_frame.h"

namespace terrace {
namespace {

/// One landmark's errors in neighbouring frames resemble each other (texture, interpolation, slant), so that
/// many observations know less than their number says. Measured on rendered walks, in variance.
constexpr double kCorrelation = 4.5;

}  // namespace

class VisualOdometry::Impl {
 public:
  Impl(const OdometryConfig& config, const StereoCamera& camera, const Mounting& mounting)
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
        vertical_(config.max_vertical_disparity_px) {}

  PoseEstimate Track(const StereoFrame& frame, const SensorSamples& samples) {
    TERRACE_CHECK(frame.left.size() == cv::Size(camera_.width, camera_.height) &&
                  frame.right.size() == frame.left.size());
    const ImagePyramid left = BuildPyramid(frame.left);
    const ImagePyramid right = BuildPyramid(frame.right);
    sightings_ = {};
    if (!last_) return Start(frame, left, right, samples);

    Read(samples, frame.t_capture);
    const Motion predicted = Predict(frame.t_capture);
    const auto found = pose_finder_.Find(window_, left, right, Expected(frame, predicted));
    if (!found) return Unfound(frame, left, right, predicted);

    PoseEstimate pose = Tracked(frame, *found);
    motion_.Correct(*last_, pose, predicted, window_.keyframes.back(), gravity_.gravity());
    if (motion_.ImuContradicts(pose, predicted)) RefuseImu();
    if (!motion_.imu_in_use()) gravity_.FollowAttitude(samples, pose);
    if (const auto warning = vertical_.Update(found->matches, found->solution)) warnings_.push_back(*warning);
    CountFates(*found, window_);
    NoteSightings(*found, window_, sightings_);
    const double age_s = Seconds(last_->t_capture - window_.keyframes.back().t_capture);
    if (keyframe_policy_.Wants(window_, left, *found, motion_.imu_in_use(), age_s)) {
      AddKeyframe(frame, left, right, pose.T_world_left, *found);
      RefineWindow(&pose);
    }
    Remember(pose);
    return pose;
  }

  PoseEstimate Bridge(FrameId frame_id, Timestamp t_capture, const SensorSamples& samples,
                      const std::string& reason) {
    sightings_ = {};
    if (!last_) {
      PoseEstimate pose;
      pose.frame_id = frame_id;
      pose.t_capture = t_capture;
      pose.reason = reason;
      return pose;
    }
    Read(samples, t_capture);
    return Bridged(frame_id, t_capture, Predict(t_capture), reason);
  }

  const Gravity& gravity() const { return gravity_.gravity(); }
  const FrameSightings& sightings() const { return sightings_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  void Apply(const GravityHint& hint) { gravity_.Take(hint); }

 private:
  PoseEstimate Start(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                     const SensorSamples& samples) {
    const WorldFrame world = LayWorldFrame(config_, mounting_, samples);
    if (!world.warning.empty() && warnings_.empty()) warnings_.push_back(world.warning);
    gravity_.Start(world.gravity);
    PoseEstimate pose;
    pose.frame_id = frame.frame_id;
    pose.t_capture = frame.t_capture;
    pose.status = TrackingStatus::kTracking;
    pose.T_world_left = world.T_world_left;
    AddKeyframe(frame, left, right, pose.T_world_left, {});
    StartWindow(Matrix6d::Zero());
    Read(samples, frame.t_capture);
    if (static_cast<int>(window_.landmarks.size()) < config_.min_inliers) {
      window_ = {};
      pose.status = TrackingStatus::kLost;
      pose.reason = "too few features to start from";
      return pose;
    }
    pose.num_matches = pose.num_inliers = static_cast<int>(window_.landmarks.size());
    Remember(pose);
    return pose;
  }

  /// A fresh prior, on the oldest keyframe of the window.
  void StartWindow(const Matrix6d& pose_covariance) {
    optimizer_ = WindowOptimizer(camera_, motion_.imu_in_use() ? mounting_.T_left_imu : std::nullopt);
    optimizer_.Start(window_.keyframes.front(), pose_covariance / kCorrelation, gravity().sigma_rad);
    keyframe_covariance_ = pose_covariance;
  }

  void Read(const SensorSamples& samples, Timestamp t_capture) {
    motion_.Read(samples, last_, t_capture, window_.keyframes.back());
    if (motion_.imu_in_use() || !motion_.has_imu() || window_.keyframes.size() > 1) return;
    // The IMU came after the first image.
    motion_.UseImu();
    gravity_.UseImu();
    StartWindow(keyframe_covariance_);
  }

  Motion Predict(Timestamp t_capture) const {
    return motion_.Predict(*last_, t_capture, window_.keyframes.back(), gravity());
  }

  void RefuseImu() {
    motion_.RefuseImu();
    warnings_.push_back(
        "the IMU turns otherwise than the images: not used any more; check T_BS of the IMU and its clock");
    gravity_.RefuseImu();
    StartWindow(keyframe_covariance_);
  }

  /// After a keyframe: all poses of the window together, then the oldest leaves.
  void RefineWindow(PoseEstimate* pose) {
    Eigen::Vector3d down_world = gravity().down_world;
    optimizer_.Optimize(window_, down_world, pose_finder_.noise_scale(), config_.optimizer_iterations);
    if (static_cast<int>(window_.keyframes.size()) > config_.window_keyframes) {
      archive_.Add(window_.keyframes.front(), window_.landmarks, keyframe_covariance_);
      optimizer_.DropOldest(window_, down_world, pose_finder_.noise_scale());
    }
    keyframe_covariance_ = kCorrelation * optimizer_.newest_covariance();
    const Keyframe& newest = window_.keyframes.back();
    pose->T_world_left = newest.T_world_left;
    pose->T_prev_left = last_->T_world_left.inverse() * pose->T_world_left;
    pose->covariance = keyframe_covariance_;
    if (!motion_.imu_in_use()) return;
    motion_.Refine(newest);
    gravity_.Refine(down_world, optimizer_.gravity_sigma_rad());
  }

  Expectation Expected(const StereoFrame& frame, const Motion& predicted) const {
    Expectation expected;
    expected.T_world_seen = bridging_.T_world_seen();
    expected.prior.T_world_left = last_->T_world_left * predicted.T_last_left;
    expected.prior.information = Inverse(bridging_.SearchCovariance(predicted));
    expected.measured = motion_.imu_in_use();
    expected.vertical_px = vertical_.vertical_px();
    expected.seed = static_cast<std::uint32_t>(frame.frame_id);
    return expected;
  }

  PoseEstimate Tracked(const StereoFrame& frame, const PoseFinder::Found& found) {
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

  PoseEstimate Bridged(FrameId frame_id, Timestamp t_capture, const Motion& predicted,
                       const std::string& reason) {
    const double scale = std::sqrt(kCorrelation);
    ImuSigmas known = optimizer_.newest_imu_sigmas();
    known = {scale * known.velocity, scale * known.gyro_bias, scale * known.accel_bias};
    PoseEstimate pose = bridging_.Extend(
        *last_, predicted, [&](double t_s) { return motion_.DriftCovariance(t_s, known, gravity()); });
    pose.frame_id = frame_id;
    pose.t_capture = t_capture;
    pose.status =
        bridging_.bridged_s() <= config_.max_bridging_s ? TrackingStatus::kBridging : TrackingStatus::kLost;
    pose.reason = reason;
    pose.vertical_disparity_px = vertical_.vertical_px();
    motion_.Bridge(predicted, gravity());
    Remember(pose);
    return pose;
  }

  /// Nothing of the window was found: bridge, and when images stay good but strange, start a new window from
  /// the bridged pose.
  PoseEstimate Unfound(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                       const Motion& predicted) {
    constexpr int kMaxStrangeFrames = 4;
    PoseEstimate pose = Bridged(frame.frame_id, frame.t_capture, predicted,
                                pose_finder_.only_strangers() ? "only what moves through the view was found"
                                                              : "too few features found again");
    const std::vector<Landmark> landmarks = keyframe_maker_.Look(left, right, vertical_.vertical_px());
    if (static_cast<int>(landmarks.size()) < 2 * config_.min_inliers) {
      pose.reason = "the images show too few features";
      return pose;
    }
    for (const Keyframe& keyframe : window_.keyframes)
      archive_.Add(keyframe, window_.landmarks, keyframe_covariance_);
    const auto known =
        archive_.Recognize(left, landmarks, pose.T_world_left, static_cast<std::uint32_t>(frame.frame_id));
    if (known && Plausible(known->T_world_left, pose)) {
      pose.status = TrackingStatus::kTracking;
      pose.reason.clear();
      pose.T_world_left = known->T_world_left;
      pose.covariance = known->covariance;
      pose.num_inliers = known->num_inliers;
      Remember(pose);
    } else if (++num_strange_frames_ < kMaxStrangeFrames) {
      return pose;
    }
    num_strange_frames_ = 0;
    const KeyframeState biases = window_.keyframes.back();
    window_ = {};
    AddKeyframe(frame, left, right, pose.T_world_left, {});
    window_.keyframes.back().gyro_bias = biases.gyro_bias;
    window_.keyframes.back().accel_bias = biases.accel_bias;
    window_.keyframes.back().velocity_world = motion_.imu_velocity_world();
    StartWindow(pose.covariance);
    return pose;
  }

  /// Places look alike: a recognised one must be where the camera can have come to since it was tracked.
  bool Plausible(const Eigen::Isometry3d& T_world_left, const PoseEstimate& bridged) const {
    constexpr double kMaxChi2 = 40.0;  // of six components; generous, as the motion is only presumed
    const Vector6d step = StepBetween(bridged.T_world_left, T_world_left);
    return Chi2(step, bridging_.covariance()) < kMaxChi2;
  }

  void Remember(const PoseEstimate& pose) {
    last_ = pose;
    if (pose.status == TrackingStatus::kTracking) bridging_.See(pose);
  }

  void AddKeyframe(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                   const Eigen::Isometry3d& T_world_left, const PoseFinder::Found& found) {
    Keyframe keyframe;
    keyframe.frame_id = frame.frame_id;
    keyframe.t_capture = frame.t_capture;
    keyframe.T_world_left = T_world_left;
    if (!window_.keyframes.empty()) motion_.FillKeyframe(window_.keyframes.back(), keyframe);
    motion_.RestartKeyframe();
    const KeyframeMaker::Made made = keyframe_maker_.Make(
        std::move(keyframe), left, right, vertical_.vertical_px(), found, window_, sightings_);
    keyframe_policy_.NoteMade(made.rests, made.covered_cells);
  }

  OdometryConfig config_;
  StereoCamera camera_;
  Mounting mounting_;
  FeatureGrid grid_;
  MotionModel motion_;
  PoseFinder pose_finder_;
  KeyframePolicy keyframe_policy_;
  KeyframeMaker keyframe_maker_;
  WindowOptimizer optimizer_;
  KeyframeArchive archive_;
  GravityKeeper gravity_;
  VerticalMonitor vertical_;
  Bridging bridging_;

  Window window_;
  Matrix6d keyframe_covariance_ = Matrix6d::Zero();  ///< of the newest keyframe against the first pose
  std::optional<PoseEstimate> last_;
  Matrix6d own_covariance_ = Matrix6d::Zero();  ///< of the last tracked frame against its keyframe
  int num_strange_frames_ = 0;                  ///< in a row, with features enough but none of the window's
  FrameSightings sightings_;                    ///< of the last frame
  std::vector<std::string> warnings_;
};

VisualOdometry::VisualOdometry(const OdometryConfig& config, const StereoCamera& camera,
                               const Mounting& mounting)
    : impl_(std::make_unique<Impl>(config, camera, mounting)) {}
VisualOdometry::~VisualOdometry() = default;

PoseEstimate VisualOdometry::Track(const StereoFrame& frame, const SensorSamples& samples) {
  PoseEstimate pose = impl_->Track(frame, samples);
  pose.trusted = pose.status == TrackingStatus::kTracking && pose.reason.empty();
  return pose;
}
PoseEstimate VisualOdometry::Bridge(FrameId frame_id, Timestamp t_capture, const SensorSamples& samples,
                                    const std::string& reason) {
  return impl_->Bridge(frame_id, t_capture, samples, reason);
}
const Gravity& VisualOdometry::gravity() const { return impl_->gravity(); }
const FrameSightings& VisualOdometry::sightings() const { return impl_->sightings(); }
const std::vector<std::string>& VisualOdometry::warnings() const { return impl_->warnings(); }
void VisualOdometry::Apply(const GravityHint& hint) { impl_->Apply(hint); }

}  // namespace terrace
