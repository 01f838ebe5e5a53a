// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/visual_odometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "odometry/covariance.h"
#include "odometry/feature_finder.h"
#include "odometry/image_pyramid.h"
#include "odometry/keyframe_archive.h"
#include "odometry/motion_model.h"
#include "odometry/pose_finder.h"
#include "odometry/rotation.h"
#include "odometry/window.h"
#include "odometry/window_optimizer.h"
#include "odometry/world_frame.h"

namespace terrace {
namespace {

/// One landmark's errors in neighbouring frames resemble each other (texture, interpolation, slant), so that
/// many observations know less than their number says. Measured on rendered walks, in variance.
constexpr double kCorrelation = 4.5;

}  // namespace

std::vector<std::string> OdometryConfig::Problems() const {
  std::vector<std::string> problems;
  const auto Require = [&problems](bool holds, const std::string& sentence) {
    if (!holds) problems.push_back(sentence);
  };
  Require(num_cells >= 40 && num_cells <= 2000, "num_cells must lie in 40..2000");
  Require(max_disparity_px >= 16 && max_disparity_px <= 512, "max_disparity_px must lie in 16..512");
  Require(window_keyframes >= 3 && window_keyframes <= 30, "window_keyframes must lie in 3..30");
  Require(keyframe_parallax > 0.0 && keyframe_parallax < 1.0, "keyframe_parallax must lie between 0 and 1");
  Require(keyframe_min_coverage > 0.0 && keyframe_min_coverage < 1.0,
          "keyframe_min_coverage must lie between 0 and 1");
  Require(min_inliers >= 6, "min_inliers must be at least 6");
  Require(archived_keyframes >= 2 && archived_keyframes <= 10000, "archived_keyframes must lie in 2..10000");
  Require(optimizer_iterations >= 0 && optimizer_iterations <= 50, "optimizer_iterations must lie in 0..50");
  Require(max_bridging_s > 0.0, "max_bridging_s must be positive");
  Require(max_vertical_disparity_px > 0.0, "max_vertical_disparity_px must be positive");
  return problems;
}

class VisualOdometry::Impl {
 public:
  Impl(const OdometryConfig& config, const StereoCamera& camera, const Mounting& mounting)
      : config_(config),
        camera_(camera),
        mounting_(mounting),
        grid_(FeatureGrid::For(camera.width, camera.height, config.num_cells)),
        motion_(config, mounting),
        pose_finder_(camera, grid_, config.min_inliers),
        finder_(camera, grid_, config.max_disparity_px),
        optimizer_(camera, std::nullopt),
        archive_(camera, config.archived_keyframes) {}

  PoseEstimate Track(const StereoFrame& frame, const SensorSamples& samples) {
    TERRACE_CHECK(frame.left.size() == cv::Size(camera_.width, camera_.height) &&
                  frame.right.size() == frame.left.size());
    const ImagePyramid left = BuildPyramid(frame.left);
    const ImagePyramid right = BuildPyramid(frame.right);
    sightings_ = {};
    TakeOverCorrection();
    if (!last_) return Start(frame, left, right, samples);

    Read(samples, frame.t_capture);
    const Motion predicted = Predict(frame.t_capture);
    const auto found = pose_finder_.Find(window_, left, right, Expected(frame, predicted));
    if (!found) return Unfound(frame, left, right, predicted);
    const std::vector<Match>& matches = found->matches;
    const PoseSolution& solution = found->solution;

    PoseEstimate pose = Tracked(frame, *found);
    motion_.Correct(*last_, pose, predicted, window_.keyframes.back(), gravity_);
    if (motion_.ImuContradicts(pose, predicted)) RefuseImu();
    FollowAttitude(samples, pose);
    UpdateVertical(matches, solution);
    CountFailures(*found);
    NoteSightings(*found);
    if (NeedsKeyframe(matches, solution) && SeesWithBoth(matches, solution) && !WaitForCertainty(*found) &&
        !WaitForSharperImage(left)) {
      AddKeyframe(frame, left, right, pose.T_world_left, matches, solution);
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

  const Gravity& gravity() const { return gravity_; }
  const FrameSightings& sightings() const { return sightings_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  void Apply(const PoseCorrection& correction) { correction_ = correction.T_corrected_world; }
  void Apply(const GravityHint& hint) {
    // An IMU or the robot's own attitude knows better.
    if (gravity_.source == GravitySource::kImu || gravity_.source == GravitySource::kAttitude) return;
    if (hint.sigma_rad >= gravity_.sigma_rad && gravity_.source != GravitySource::kAssumed) return;
    gravity_ = {hint.down_world.normalized(), hint.sigma_rad, GravitySource::kPlane};
  }

 private:
  PoseEstimate Start(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                     const SensorSamples& samples) {
    const WorldFrame world = LayWorldFrame(config_, mounting_, samples);
    if (!world.warning.empty() && warnings_.empty()) warnings_.push_back(world.warning);
    gravity_ = world.gravity;
    PoseEstimate pose;
    pose.frame_id = frame.frame_id;
    pose.t_capture = frame.t_capture;
    pose.status = TrackingStatus::kTracking;
    pose.T_world_left = world.T_world_left;
    AddKeyframe(frame, left, right, pose.T_world_left, {}, {});
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
    optimizer_.Start(window_.keyframes.front(), pose_covariance / kCorrelation, gravity_.sigma_rad);
    keyframe_covariance_ = pose_covariance;
  }

  /// The robot's own attitude, at a tracked frame, makes up better known.
  void FollowAttitude(const SensorSamples& samples, const PoseEstimate& pose) {
    if (!config_.use_priors || !mounting_.T_body_left || motion_.imu_in_use()) return;
    const BodyPrior* newest = nullptr;
    for (const BodyPrior& prior : samples.priors)
      if (prior.kind == PriorKind::kAttitude) newest = &prior;
    if (!newest) return;
    constexpr double kMinSigmaRad = 0.002;
    constexpr double kDriftRad = 0.0002;  // of the pose, per frame
    constexpr double kBias = 0.8;         // share of its error that averaging cannot remove
    const double own =
        std::max(std::sqrt(0.5 * (newest->covariance(0, 0) + newest->covariance(1, 1))), kMinSigmaRad);
    const Eigen::Vector3d down_body = -(newest->T_odom_body.linear().transpose() * Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d down_world =
        pose.T_world_left.linear() * (mounting_.T_body_left->linear().transpose() * down_body);
    const double before = gravity_.sigma_rad * gravity_.sigma_rad + kDriftRad * kDriftRad;
    const double gain = gravity_.source == GravitySource::kAttitude ? before / (before + own * own) : 1.0;
    gravity_.down_world = ((1.0 - gain) * gravity_.down_world + gain * down_world).normalized();
    gravity_.sigma_rad =
        std::max(std::sqrt((1.0 - gain) * before + (gain == 1.0 ? own * own : 0.0)), kBias * own);
    gravity_.source = GravitySource::kAttitude;
  }

  void Read(const SensorSamples& samples, Timestamp t_capture) {
    motion_.Read(samples, last_, t_capture, window_.keyframes.back());
    if (motion_.imu_in_use() || !motion_.has_imu() || window_.keyframes.size() > 1) return;
    // The IMU came after the first image.
    motion_.UseImu();
    gravity_.source = GravitySource::kImu;
    StartWindow(keyframe_covariance_);
  }

  Motion Predict(Timestamp t_capture) const {
    return motion_.Predict(*last_, t_capture, window_.keyframes.back(), gravity_);
  }

  void RefuseImu() {
    motion_.RefuseImu();
    warnings_.push_back(
        "the IMU turns otherwise than the images: not used any more; check T_BS of the IMU and its clock");
    gravity_.source = mounting_.T_body_left ? GravitySource::kMounting : GravitySource::kAssumed;
    gravity_.sigma_rad = std::max(gravity_.sigma_rad, 0.05);
    StartWindow(keyframe_covariance_);
  }

  /// After a keyframe: all poses of the window together, then the oldest leaves.
  void RefineWindow(PoseEstimate* pose) {
    optimizer_.Optimize(window_, gravity_.down_world, pose_finder_.noise_scale(),
                        config_.optimizer_iterations);
    if (static_cast<int>(window_.keyframes.size()) > config_.window_keyframes) {
      archive_.Add(window_.keyframes.front(), window_.landmarks, keyframe_covariance_);
      optimizer_.DropOldest(window_, gravity_.down_world, pose_finder_.noise_scale());
    }
    keyframe_covariance_ = kCorrelation * optimizer_.newest_covariance();
    const Keyframe& newest = window_.keyframes.back();
    pose->T_world_left = newest.T_world_left;
    pose->T_prev_left = last_->T_world_left.inverse() * pose->T_world_left;
    pose->covariance = keyframe_covariance_;
    if (motion_.imu_in_use()) {
      motion_.Refine(newest);
      gravity_.sigma_rad = optimizer_.gravity_sigma_rad();
    }
  }

  /// Moves everything a little towards where the map wants it.
  void TakeOverCorrection() {
    constexpr double kMaxStepM = 0.0005;
    constexpr double kMaxStepRad = 0.0002;
    if (!last_ || correction_.isApprox(Eigen::Isometry3d::Identity(), 1e-12)) return;
    // About the camera, so that a far origin does not turn a small rotation into a large step.
    Eigen::Isometry3d T_world_here = Eigen::Isometry3d::Identity();
    T_world_here.translation() = last_->T_world_left.translation();
    const Eigen::Isometry3d whole = T_world_here.inverse() * correction_ * T_world_here;
    const Vector6d step = StepBetween(Eigen::Isometry3d::Identity(), whole);
    const double share = std::min({1.0, kMaxStepM / std::max(step.tail<3>().norm(), 1e-12),
                                   kMaxStepRad / std::max(step.head<3>().norm(), 1e-12)});
    const Eigen::Isometry3d move =
        T_world_here * Perturb(Eigen::Isometry3d::Identity(), share * step) * T_world_here.inverse();
    for (Keyframe& keyframe : window_.keyframes) keyframe.T_world_left = move * keyframe.T_world_left;
    last_->T_world_left = move * last_->T_world_left;
    T_world_seen_ = move * T_world_seen_;
    optimizer_.Move(move);
    correction_ = correction_ * move.inverse();
  }

  Expectation Expected(const StereoFrame& frame, const Motion& predicted) const {
    Expectation expected;
    expected.T_world_seen = T_world_seen_;
    expected.prior.T_world_left = last_->T_world_left * predicted.T_last_left;
    expected.prior.information =
        Inverse(TransportCovariance(predicted.T_last_left, bridge_covariance_) + predicted.covariance);
    expected.measured = motion_.imu_in_use();
    expected.vertical_px = vertical_px_;
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
    pose.vertical_disparity_px = vertical_px_;
    bridged_s_ = 0.0;
    bridge_covariance_.setZero();
    num_strange_frames_ = 0;
    return pose;
  }

  PoseEstimate Bridged(FrameId frame_id, Timestamp t_capture, const Motion& predicted,
                       const std::string& reason) {
    bridged_s_ += predicted.dt_s;
    PoseEstimate pose;
    pose.frame_id = frame_id;
    pose.t_capture = t_capture;
    pose.status = bridged_s_ <= config_.max_bridging_s ? TrackingStatus::kBridging : TrackingStatus::kLost;
    pose.reason = reason;
    pose.T_world_left = last_->T_world_left * predicted.T_last_left;
    pose.T_prev_left = predicted.T_last_left;
    if (predicted.by_legs) {
      pose.covariance_prev = predicted.covariance;
      pose.covariance = TransportCovariance(predicted.T_last_left, last_->covariance) + predicted.covariance;
    } else {
      // An error of the velocity goes on: it grows with the time, not with its root.
      const double scale = std::sqrt(kCorrelation);
      ImuSigmas known = optimizer_.newest_imu_sigmas();
      known = {scale * known.velocity, scale * known.gyro_bias, scale * known.accel_bias};
      const auto DriftAfter = [&](double t_s) { return motion_.DriftCovariance(t_s, known, gravity_); };
      const Matrix6d drift = DriftAfter(bridged_s_);
      const Matrix6d before = DriftAfter(bridged_s_ - predicted.dt_s);
      pose.covariance =
          TransportCovariance(T_world_seen_.inverse() * pose.T_world_left, seen_covariance_) + drift;
      const Vector6d step = drift.diagonal().cwiseSqrt() - before.diagonal().cwiseSqrt();
      pose.covariance_prev = step.cwiseAbs2().asDiagonal();
    }
    bridge_covariance_ =
        TransportCovariance(predicted.T_last_left, bridge_covariance_) + predicted.covariance;
    pose.vertical_disparity_px = vertical_px_;
    motion_.Bridge(predicted, gravity_);
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
    const std::vector<bool> nothing(static_cast<std::size_t>(grid_.num_cells()), false);
    std::vector<Landmark> landmarks = finder_.Find(left, right, nothing, vertical_px_);
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
      bridged_s_ = 0.0;
      bridge_covariance_.setZero();
      Remember(pose);
    } else if (++num_strange_frames_ < kMaxStrangeFrames) {
      return pose;
    }
    num_strange_frames_ = 0;
    const KeyframeState biases = window_.keyframes.back();
    window_ = {};
    AddKeyframe(frame, left, right, pose.T_world_left, {}, {});
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
    return Chi2(step, bridge_covariance_) < kMaxChi2;
  }

  void Remember(const PoseEstimate& pose) {
    last_ = pose;
    if (pose.status != TrackingStatus::kTracking) return;
    T_world_seen_ = pose.T_world_left;
    seen_covariance_ = pose.covariance;
  }

  void UpdateVertical(const std::vector<Match>& matches, const PoseSolution& solution) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < matches.size(); ++i)
      if (solution.inlier[i] && matches[i].measurement.has_disparity)
        errors.push_back(matches[i].vertical_px);
    constexpr std::size_t kEnough = 20;
    if (errors.size() < kEnough) return;
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                     errors.end());
    constexpr double kRate = 0.03;
    vertical_px_ += kRate * (errors[errors.size() / 2] - vertical_px_);
    if (std::abs(vertical_px_) > config_.max_vertical_disparity_px && !warned_of_vertical_) {
      warned_of_vertical_ = true;
      warnings_.push_back("the right image lies " + std::to_string(vertical_px_) +
                          " px lower than the calibration says: calibrate the cameras again");
    }
  }

  void CountFailures(const PoseFinder::Found& found) {
    for (const int i : found.tried) {
      Landmark& landmark = window_.landmarks[static_cast<std::size_t>(i)];
      ++landmark.num_missed;
      landmark.missed_last = true;
    }
    for (std::size_t i = 0; i < found.matches.size(); ++i) {
      Landmark& landmark = window_.landmarks[static_cast<std::size_t>(found.matches[i].landmark)];
      const bool agrees = found.solution.inlier[i];
      landmark.num_failures = agrees ? 0 : landmark.num_failures + 1;
      landmark.num_tracked += agrees;
      landmark.num_missed -= agrees;
      landmark.missed_last = !agrees;
    }
  }

  void NoteSightings(const PoseFinder::Found& found) {
    for (std::size_t i = 0; i < found.matches.size(); ++i)
      sightings_.landmarks.push_back(
          {window_.landmarks[static_cast<std::size_t>(found.matches[i].landmark)].id,
           found.matches[i].measurement.uvd.head<2>().cast<float>(),
           found.solution.inlier[i] ? LandmarkFate::kAgrees : LandmarkFate::kRejected});
  }

  bool NeedsKeyframe(const std::vector<Match>& matches, const PoseSolution& solution) const {
    const Keyframe& newest = window_.keyframes.back();
    const double distance = (solution.T_world_left.translation() - newest.T_world_left.translation()).norm();
    std::vector<bool> held(static_cast<std::size_t>(grid_.num_cells()), false);
    std::vector<double> inverse_depths;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (!solution.inlier[i]) continue;
      held[static_cast<std::size_t>(
          grid_.CellOf(matches[i].measurement.uvd.x(), matches[i].measurement.uvd.y()))] = true;
      inverse_depths.push_back(matches[i].predicted.uvd.z() / (camera_.fx * camera_.baseline_m));
    }
    const double coverage = static_cast<double>(std::count(held.begin(), held.end(), true)) / covered_cells_;
    if (coverage < config_.keyframe_min_coverage) return true;
    auto middle = inverse_depths.begin() + static_cast<std::ptrdiff_t>(inverse_depths.size() / 2);
    std::nth_element(inverse_depths.begin(), middle, inverse_depths.end());
    if (distance * *middle > config_.keyframe_parallax) return true;
    // At rest gravity and biases show without parallax; a few keyframes are enough, more would only drift.
    constexpr double kPeriod_s = 1.0;
    return motion_.imu_in_use() && keyframes_at_rest_ < config_.window_keyframes - 2 &&
           Seconds(last_->t_capture - newest.t_capture) > kPeriod_s;
  }

  /// Without the right image a keyframe would make no landmarks, and drive out an old one that has some.
  static bool SeesWithBoth(const std::vector<Match>& matches, const PoseSolution& solution) {
    constexpr double kMinShare = 0.02;
    int with_disparity = 0;
    for (std::size_t i = 0; i < matches.size(); ++i)
      with_disparity += solution.inlier[i] && matches[i].measurement.has_disparity;
    return with_disparity >= kMinShare * solution.num_inliers;
  }

  /// Nothing is built on a pose in doubt, unless the doubt goes on.
  bool WaitForCertainty(const PoseFinder::Found& found) {
    constexpr int kPatience = 4;  // frames
    num_doubtful_ = found.doubt ? num_doubtful_ + 1 : 0;
    return found.doubt && num_doubtful_ <= kPatience;
  }

  /// A blurred keyframe would blur all that is found with its texture: better a later one, unless that goes
  /// on.
  bool WaitForSharperImage(const ImagePyramid& left) {
    constexpr double kBlurred = 0.65;  // of the usual sharpness
    constexpr double kRate = 0.2;
    constexpr int kPatience = 4;  // frames
    const double sharpness = Sharpness(left);
    const bool blurred = sharpness < kBlurred * usual_sharpness_;
    usual_sharpness_ += kRate * (sharpness - usual_sharpness_);
    num_waited_ = blurred ? num_waited_ + 1 : 0;
    return blurred && num_waited_ <= kPatience;
  }

  void AddKeyframe(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                   const Eigen::Isometry3d& T_world_left, const std::vector<Match>& matches,
                   const PoseSolution& solution) {
    Keyframe keyframe;
    keyframe.id = next_keyframe_id_++;
    keyframe.frame_id = frame.frame_id;
    keyframe.t_capture = frame.t_capture;
    keyframe.T_world_left = T_world_left;
    keyframe.left = left;
    if (!window_.keyframes.empty()) motion_.FillKeyframe(window_.keyframes.back(), keyframe);
    motion_.RestartKeyframe();
    constexpr double kRest_m = 0.005;
    const bool rests =
        !window_.keyframes.empty() &&
        (T_world_left.translation() - window_.keyframes.back().T_world_left.translation()).norm() < kRest_m;
    keyframes_at_rest_ = rests ? keyframes_at_rest_ + 1 : 0;

    // Cells where a landmark is seen much as in its host need no new one.
    constexpr double kSameScale = 1.4;
    std::vector<bool> occupied(static_cast<std::size_t>(grid_.num_cells()), false);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (!solution.inlier[i]) continue;
      const StereoMeasurement& m = matches[i].measurement;
      window_.landmarks[static_cast<std::size_t>(matches[i].landmark)].observations.push_back(
          {keyframe.id, m});
      if (matches[i].scale < kSameScale && matches[i].scale > 1.0 / kSameScale)
        occupied[static_cast<std::size_t>(grid_.CellOf(m.uvd.x(), m.uvd.y()))] = true;
    }
    window_.keyframes.push_back(std::move(keyframe));
    sightings_.is_keyframe = true;
    for (Landmark& landmark : finder_.Find(left, right, occupied, vertical_px_)) {
      landmark.id = next_landmark_id_++;
      landmark.host = window_.keyframes.back().id;
      sightings_.landmarks.push_back(
          {landmark.id, landmark.pixel_host.cast<float>(), LandmarkFate::kCreated});
      window_.landmarks.push_back(std::move(landmark));
    }
    constexpr int kMaxFailures = 3;
    std::erase_if(window_.landmarks,
                  [](const Landmark& landmark) { return landmark.num_failures >= kMaxFailures; });

    std::vector<bool> covered = occupied;
    for (const Landmark& landmark : window_.landmarks)
      if (landmark.host == window_.keyframes.back().id)
        covered[static_cast<std::size_t>(grid_.CellOf(landmark.pixel_host.x(), landmark.pixel_host.y()))] =
            true;
    covered_cells_ =
        std::max<double>(1.0, static_cast<double>(std::count(covered.begin(), covered.end(), true)));
  }

  OdometryConfig config_;
  StereoCamera camera_;
  Mounting mounting_;
  FeatureGrid grid_;
  MotionModel motion_;
  PoseFinder pose_finder_;
  FeatureFinder finder_;

  WindowOptimizer optimizer_;
  KeyframeArchive archive_;

  Window window_;
  KeyframeId next_keyframe_id_ = 0;
  std::int64_t next_landmark_id_ = 0;
  double usual_sharpness_ = 0.0;                     ///< of frames that would become keyframes
  int num_waited_ = 0;                               ///< for a sharper one, frames in a row
  int num_doubtful_ = 0;                             ///< poses that would become keyframes, in a row
  double covered_cells_ = 1.0;                       ///< cells with a landmark just after the newest keyframe
  Matrix6d keyframe_covariance_ = Matrix6d::Zero();  ///< of the newest keyframe against the first pose

  std::optional<PoseEstimate> last_;
  int keyframes_at_rest_ = 0;                   ///< in a row
  Matrix6d own_covariance_ = Matrix6d::Zero();  ///< of the last tracked frame against its keyframe
  Eigen::Isometry3d T_world_seen_ = Eigen::Isometry3d::Identity();  ///< where the camera was tracked last
  Matrix6d seen_covariance_ = Matrix6d::Zero();                     ///< of that
  double bridged_s_ = 0.0;
  Matrix6d bridge_covariance_ = Matrix6d::Zero();  ///< of the last pose against the last that was tracked
  int num_strange_frames_ = 0;  ///< in a row, with features enough but none of the window's

  FrameSightings sightings_;                                      ///< of the last frame
  Eigen::Isometry3d correction_ = Eigen::Isometry3d::Identity();  ///< still to be taken over
  Gravity gravity_;
  double vertical_px_ = 0.0;
  bool warned_of_vertical_ = false;
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
void VisualOdometry::Apply(const PoseCorrection& correction) { impl_->Apply(correction); }
void VisualOdometry::Apply(const GravityHint& hint) { impl_->Apply(hint); }

}  // namespace terrace
