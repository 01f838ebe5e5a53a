// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/visual_odometry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/check.h"
#include "core/print.h"
#include "odometry/bridging.h"
#include "odometry/column_monitor.h"
#include "odometry/covariance.h"
#include "odometry/credible.h"
#include "odometry/floor_check.h"
#include "odometry/image_pyramid.h"
#include "odometry/imu_check.h"
#include "odometry/imu_watch.h"
#include "odometry/keyframe_archive.h"
#include "odometry/keyframe_maker.h"
#include "odometry/keyframe_policy.h"
#include "odometry/motion_model.h"
#include "odometry/pose_finder.h"
#include "odometry/rotation.h"
#include "odometry/row_changes.h"
#include "odometry/standing_images.h"
#include "odometry/turn_comparison.h"
#include "odometry/vertical_monitor.h"
#include "odometry/window.h"
#include "odometry/window_optimizer.h"
#include "odometry/witness.h"
#include "odometry/world_frame.h"

namespace terrace {
namespace {

/// One landmark's errors in neighbouring frames resemble each other (texture, interpolation, slant), so that
/// many observations know less than their number says. Measured on rendered walks, in variance.
constexpr double kCorrelation = 4.5;
/// Rad and m: no prediction is better than this.
constexpr double kLeastSigma = 0.001;
constexpr const char* kNotOfOneMoment =
    "the rows of the right image come and go: the two images are not of one moment, one camera is late";

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
        vertical_(config.max_vertical_disparity_px),
        columns_(camera) {}

  PoseEstimate Track(const StereoFrame& frame, const SensorSamples& samples) {
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
    if (expected.lost) motion_.Lose();
    motion_.Correct(*last_, pose, predicted, window_.keyframes.back(), gravity_.gravity());
    if (!motion_.imu_in_use()) gravity_.FollowAttitude(samples, pose);
    for (const auto& warning : {motion_.legs().TakeWarning(), gravity_.TakeWarning()})
      if (warning) warnings_.push_back(*warning);
    if (const auto warning = vertical_.Update(found->matches, found->solution)) warnings_.push_back(*warning);
    WatchPair(*found, pose);
    CountFates(*found, window_);
    NoteSightings(*found, window_, sightings_);
    const double age_s = Seconds(last_->t_capture - window_.keyframes.back().t_capture);
    if (!in_doubt && keyframe_policy_.Wants(window_, left, *found, motion_.imu_in_use(), age_s)) {
      AddKeyframe(frame, left, right, pose.T_world_left, *found);
      RefineWindow(&pose);
    }
    // Measured on walks with a camera that is a frame late: accelerations are wrong by a share of the gait's.
    constexpr double kUp_rad = 3.0 * M_PI / 180.0;
    if (PairInDoubt()) gravity_.Doubt(kUp_rad);
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
      pose.reason_code = ReasonCode::kUnreadableImages;
      return pose;
    }
    if (t_capture <= last_->t_capture) LoseTime(t_capture);
    Read(samples, t_capture);
    PoseEstimate pose = Bridged(frame_id, t_capture, Predict(t_capture), reason);
    pose.reason_code = ReasonCode::kUnreadableImages;
    return pose;
  }

  /// What is given out: with the epoch, and whether it may be mapped.
  PoseEstimate Published(PoseEstimate pose) const {
    pose.epoch = epoch_;
    if (pose.status == TrackingStatus::kTracking && pose.reason.empty() && PairInDoubt()) {
      const bool late = row_changes_.come_and_go();
      pose.reason = late ? kNotOfOneMoment : columns_.Reason();
      pose.reason_code = late ? ReasonCode::kInputTrouble : ReasonCode::kBadCalibration;
    }
    pose.trusted = pose.status == TrackingStatus::kTracking && pose.reason.empty();
    return pose;
  }
  /// Samples that can have been measured; tells the user once when some cannot.
  SensorSamples Believable(const SensorSamples& samples) {
    const bool told = num_incredible_ > 0;
    SensorSamples credible = Credible(samples, &num_incredible_);
    if (!told && num_incredible_ > 0)
      warnings_.push_back(
          "a reading of the IMU, attitude or leg odometry is not finite or beyond what a sensor can measure: "
          "such readings are left out");
    return credible;
  }

  const Gravity& gravity() const { return gravity_.gravity(); }
  const FrameSightings& sightings() const { return sightings_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  void Apply(const GravityHint& hint) { gravity_.Take(hint); }

 private:
  /// @param biases  of the IMU, as far as they are known
  PoseEstimate Start(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                     const SensorSamples& samples, const KeyframeState& biases) {
    const WorldFrame world = LayWorld(frame, left, right, samples);
    if (!world.warning.empty() && warnings_.empty()) warnings_.push_back(world.warning);
    gravity_.Start(world.gravity, world.without_imu, DownIfLevel(world.T_world_left));
    if (mounting_.T_left_imu)
      imu_check_ = ImuCheck(-((world.T_world_left.linear() * mounting_.T_left_imu->linear()).transpose() *
                              world.without_imu.down_world));
    PoseEstimate pose;
    pose.frame_id = frame.frame_id;
    pose.t_capture = frame.t_capture;
    pose.status = TrackingStatus::kTracking;
    pose.T_world_left = world.T_world_left;
    window_.keyframes.back().gyro_bias = biases.gyro_bias;
    window_.keyframes.back().accel_bias = biases.accel_bias;
    StartWindow(Matrix6d::Zero());
    Read(samples, frame.t_capture);
    if (static_cast<int>(window_.landmarks.size()) < config_.min_inliers) {
      window_ = {};
      pose.status = TrackingStatus::kLost;
      pose.reason = "too few features to start from";
      pose.reason_code = ReasonCode::kFewFeatures;
      return pose;
    }
    pose.num_matches = pose.num_inliers = static_cast<int>(window_.landmarks.size());
    Remember(pose);
    return pose;
  }

  /// With the first keyframe in it. The floor that this shows may confirm a body that was taken for the axes
  /// of a sensor, where the robot itself says nothing.
  WorldFrame LayWorld(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                      const SensorSamples& samples) {
    WorldFrame world = LayWorldFrame(config_, mounting_, samples);
    AddKeyframe(frame, left, right, world.T_world_left, {});
    const bool robot_speaks = config_.use_priors && !samples.priors.empty();
    if (world.warning.empty() || robot_speaks) return world;
    std::vector<Eigen::Vector3d> points_left;
    for (const Landmark& landmark : window_.landmarks)
      points_left.push_back(landmark.ray_host / landmark.inverse_depth);
    const Eigen::Vector3d body_up_left =
        mounting_.T_body_left->linear().transpose() * Eigen::Vector3d::UnitZ();
    if (!FloorConfirmsBody(points_left, body_up_left, mounting_.image_up_left)) return world;
    mounting_.source = MountingSource::kBody;
    world = LayWorldFrame(config_, mounting_, samples);
    window_.keyframes.back().T_world_left = world.T_world_left;
    warnings_.push_back(
        "the camera is turned far against the body's up; the floor confirms that it sits so on the robot");
    return world;
  }

  Eigen::Vector3d DownIfLevel(const Eigen::Isometry3d& T_world_left) const {
    if (!mounting_.T_body_left) return -Eigen::Vector3d::UnitZ();
    return -(T_world_left.linear() * mounting_.T_body_left->linear().transpose() * Eigen::Vector3d::UnitZ());
  }

  /// Where the camera has come to cannot be known any more: another world begins at this frame.
  PoseEstimate BeginAnew(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                         const SensorSamples& samples) {
    ++epoch_;
    const KeyframeState biases = window_.keyframes.back();
    window_ = {};
    archive_ = KeyframeArchive(camera_, config_.archived_keyframes);
    bridging_ = {};
    witness_.Reset();
    own_covariance_.setZero();
    last_.reset();
    motion_.Restart();
    return Start(frame, left, right, samples, biases);
  }

  /// A fresh prior, on the oldest keyframe of the window.
  void StartWindow(const Matrix6d& pose_covariance, const ImuSigmas& imu = ImuSigmas::AtFirst()) {
    optimizer_ = WindowOptimizer(camera_, motion_.imu_in_use() ? mounting_.T_left_imu : std::nullopt);
    optimizer_.Start(window_.keyframes.front(), pose_covariance / kCorrelation, gravity().sigma_rad, imu);
    keyframe_covariance_ = pose_covariance;
  }

  void Read(const SensorSamples& samples, Timestamp t_capture) {
    if (config_.use_imu && mounting_.T_left_imu && !motion_.imu_refused()) ReadImu(samples.imu, t_capture);
    if (last_ && Seconds(t_capture - last_->t_capture) > config_.max_bridging_s)
      warnings_.push_back(
          Printed("no image for %.1f s: the cameras were silent, or the clock was set forward",
                  Seconds(t_capture - last_->t_capture)));
    motion_.Read(samples, last_, t_capture, window_.keyframes.back());
    if (motion_.imu_in_use() || !motion_.has_imu() || window_.keyframes.size() > 1) return;
    // The IMU came after the first image.
    motion_.UseImu();
    gravity_.UseImu();
    StartWindow(keyframe_covariance_);
  }

  void ReadImu(const std::vector<ImuSample>& samples, Timestamp t_capture) {
    std::optional<std::string> problem = imu_check_.Read(samples, t_capture);
    const std::optional<std::string> clipped = imu_watch_.Read(samples);
    if (!problem) problem = clipped;
    if (problem) return RefuseImu(*problem);
    if (imu_watch_.HasFallenSilent(t_capture))
      warnings_.push_back("the IMU says nothing any more: until it does, nothing is known by it");
  }

  /// Why these images cannot be what the cameras see now; empty: they can. Both standing still is no fault of
  /// a robot that stands, or of a recording of one pair.
  std::string Frozen(const Motion& predicted) {
    if (standing_.left_alone()) return "the left camera gives the same image again and again: it is frozen";
    constexpr double kMoves_m = 0.01, kMoves_rad = 0.004;  // in a frame; more than a sensor at rest says
    const bool measured = witness_.proven() && (predicted.by_imu || predicted.by_legs);
    const bool moves = measured && (predicted.T_last_left.translation().norm() > kMoves_m ||
                                    LogRotation(predicted.T_last_left.linear()).norm() > kMoves_rad);
    frozen_ = standing_.both() && (frozen_ || moves);
    return frozen_ ? "both cameras give the same images again and again: they are frozen" : "";
  }

  /// What cannot be is not predicted: then the camera is taken to stay where it is.
  Motion Predict(Timestamp t_capture) const {
    Motion motion = motion_.Predict(*last_, t_capture, window_.keyframes.back(), gravity());
    const bool can_be = IsPose(motion.T_last_left) && CanMove(motion.T_last_left, motion.dt_s) &&
                        motion.covariance.allFinite() && motion.velocity_world.norm() < config_.max_speed_mps;
    if (can_be) return motion;
    Motion rest;
    rest.dt_s = std::max(motion.dt_s, 0.0);
    const double reach_m = config_.max_speed_mps * rest.dt_s;
    rest.covariance.diagonal() << Vector6d::Constant(reach_m * reach_m);
    rest.covariance.diagonal().array() += kLeastSigma * kLeastSigma;
    return rest;
  }

  /// False for what is farther than the robot can go in this time.
  bool CanMove(const Eigen::Isometry3d& T_last_left, double dt_s) const {
    constexpr double kSlackM = 0.5;  // of the pose before
    constexpr double kSlackRad = 0.5;
    const double max_turn_rad = config_.max_turn_rate_dps * M_PI / 180.0 * dt_s;
    return T_last_left.translation().norm() < config_.max_speed_mps * dt_s + kSlackM &&
           LogRotation(T_last_left.linear()).norm() < max_turn_rad + kSlackRad;
  }
  bool CanHaveMovedTo(const Eigen::Isometry3d& T_world_left, double dt_s) const {
    return IsPose(T_world_left) &&
           CanMove(bridging_.T_world_seen().inverse() * T_world_left, bridging_.bridged_s() + dt_s);
  }

  /// The clock was set back: nobody knows how much time has passed.
  void LoseTime(Timestamp t_capture) {
    bridging_.LoseTime();
    motion_.LoseTime();
    last_->t_capture = t_capture;
  }

  bool Lost() const { return bridging_.bridged_s() > config_.max_bridging_s; }

  void RefuseImu(const std::string& why) {
    motion_.RefuseImu();
    witness_.Reset();
    turns_.Reset();
    warnings_.push_back(why + "; the IMU is not used any more");
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

  /// What the sensor that has measured the motion says to what the images show. Who has contradicted until
  /// all was lost does so still.
  Witness::Verdict Hear(const Expectation& expected, const Motion& predicted,
                        const Eigen::Isometry3d& T_world_found) {
    if (expected.lost)
      return witness_.contradicts() ? Witness::Verdict::kContradicts : Witness::Verdict::kAgrees;
    if (!predicted.by_imu && !predicted.by_legs) return Witness::Verdict::kAgrees;
    return witness_.Hear(StepBetween(expected.prior.T_world_left, T_world_found),
                         bridging_.ExpectedCovariance(predicted), predicted.dt_s);
  }

  /// Why the IMU cannot be believed, by what the images show.
  std::optional<std::string> ImuProblem(const Expectation& expected, const Motion& predicted,
                                        const Eigen::Isometry3d& T_world_found) {
    if (expected.lost || !predicted.by_imu) return std::nullopt;
    const Eigen::Matrix3d R_seen_world = expected.T_world_seen.linear().transpose();
    const Eigen::Vector3d by_images = LogRotation(R_seen_world * T_world_found.linear());
    constexpr double kTurns_rad = 0.005;
    if (imu_watch_.stands() && by_images.norm() > kTurns_rad)
      return "the IMU gives the same reading again and again while the images turn: it is frozen";
    turns_.Hear(LogRotation(R_seen_world * expected.prior.T_world_left.linear()), by_images, predicted.dt_s);
    return turns_.Problem();
  }

  /// What passes by hardly seems to turn the camera: then it is the IMU that is wrong. Legs slip a little
  /// all the time, and as long as they have not walked in agreement they may be wrong altogether.
  bool WitnessIsWrong(Witness::Verdict verdict, const Motion& predicted) {
    if (predicted.by_imu) return witness_.turns_otherwise();
    return verdict == Witness::Verdict::kDriftsApart || motion_.legs().unproven();
  }

  /// How well the IMU's state is known after bridging by it.
  ImuSigmas BridgedImu() const {
    if (!motion_.imu_in_use() || Lost()) return ImuSigmas::AtFirst();
    constexpr double kLeast = 0.02;  // m/s: the steps between frames have correlated with the poses
    ImuSigmas known = optimizer_.newest_imu_sigmas();
    const double t = bridging_.bridged_s();
    known.velocity += kLeast + (known.accel_bias + kGravityMagnitude * gravity().sigma_rad) * t;
    return known;
  }

  /// The images and the sensor exclude each other, and a thing that fills the view is likelier than a sensor
  /// that fails just now: goes on by the sensor, uncertain by how far the two are apart.
  PoseEstimate Contradicted(const StereoFrame& frame, const Motion& predicted,
                            const Eigen::Isometry3d& T_world_found) {
    PoseEstimate pose = Bridged(frame.frame_id, frame.t_capture, predicted, Apart(predicted));
    pose.reason_code = ReasonCode::kAmbiguousMotion;
    const Vector6d apart = StepBetween(pose.T_world_left, T_world_found);
    contested_ = apart * apart.transpose();
    pose.covariance += contested_;
    return pose;
  }

  void Doubt(const Motion& predicted, PoseEstimate* pose) {
    pose->reason = Apart(predicted);
    pose->reason_code = ReasonCode::kAmbiguousMotion;
    pose->covariance += witness_.apart() * witness_.apart().transpose();
    if (witness_.disagreed_s() < config_.max_bridging_s) return;
    if (predicted.by_imu)
      RefuseImu("the IMU moves otherwise than the images: check its units, T_BS and its clock");
    else
      motion_.legs().Refuse();
    witness_.Reset();
  }

  /// What the landmarks' places in both images say of how the two cameras stand to each other.
  void WatchPair(const PoseFinder::Found& found, const PoseEstimate& pose) {
    if (row_changes_.Update(window_, found.matches)) warnings_.push_back(kNotOfOneMoment);
    // Columns that come and go are those of a camera that is late, too.
    if (row_changes_.come_and_go()) return;
    const auto warning =
        columns_.Update(window_, found.matches, pose.T_world_left, pose_finder_.noise_scale());
    if (warning) warnings_.push_back(*warning);
  }
  /// Then distances are wrong, and the pose is off by a share of the way.
  bool PairInDoubt() const { return row_changes_.come_and_go() || columns_.is_off(); }

  static std::string Apart(const Motion& predicted) {
    return std::string("the images show another motion than the ") + (predicted.by_imu ? "IMU" : "legs") +
           ": something large moves through the view, or the sensor is wrong";
  }

  /// For too long the images and a sensor have excluded each other.
  PoseEstimate BeginWithout(const Motion& predicted, const StereoFrame& frame, const ImagePyramid& left,
                            const ImagePyramid& right, const SensorSamples& samples) {
    if (predicted.by_legs) motion_.legs().Refuse();
    return BeginAnew(frame, left, right, samples);
  }

  Expectation Expected(const StereoFrame& frame, const Motion& predicted) const {
    Expectation expected;
    expected.T_world_seen = bridging_.T_world_seen();
    expected.prior.T_world_left = Chained(last_->T_world_left, predicted.T_last_left);
    expected.prior.information = Inverse(bridging_.SearchCovariance(predicted));
    expected.measured = motion_.imu_in_use();
    if (bridging_.bridged_s() + predicted.dt_s > config_.max_bridging_s) {
      constexpr double kLostSigma = 0.3;  // rad and m: searches go on from there
      expected.prior.information = Matrix6d::Identity() / (kLostSigma * kLostSigma);
      expected.measured = false;
      expected.lost = true;
    }
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

  PoseEstimate Bridged(FrameId frame_id, Timestamp t_capture, const Motion& predicted,
                       const std::string& reason) {
    const bool was_lost = Lost();
    const double scale = std::sqrt(kCorrelation);
    ImuSigmas known = optimizer_.newest_imu_sigmas();
    known = {scale * known.velocity, scale * known.gyro_bias, scale * known.accel_bias};
    const auto DriftAfter = [&](double t_s) { return motion_.DriftCovariance(t_s, known, gravity()); };
    PoseEstimate pose =
        was_lost ? bridging_.Hold(*last_, predicted.dt_s) : bridging_.Extend(*last_, predicted, DriftAfter);
    pose.frame_id = frame_id;
    pose.t_capture = t_capture;
    pose.status = Lost() ? TrackingStatus::kLost : TrackingStatus::kBridging;
    pose.reason = reason;
    pose.vertical_disparity_px = vertical_.vertical_px();
    if (Lost())
      motion_.Lose();
    else
      motion_.Bridge(predicted, gravity());
    Remember(pose);
    return pose;
  }

  /// Nothing of the window was found: bridge, and look whether the place is known from before. When images
  /// stay good but strange, a new window starts from the bridged pose; where nobody knows any more where that
  /// is, another world begins.
  PoseEstimate Unfound(const StereoFrame& frame, const ImagePyramid& left, const ImagePyramid& right,
                       const SensorSamples& samples, const Motion& predicted) {
    constexpr int kMaxStrangeFrames = 4;
    PoseEstimate pose = Bridged(frame.frame_id, frame.t_capture, predicted,
                                pose_finder_.only_strangers() ? "only what moves through the view was found"
                                                              : "too few features found again");
    pose.reason_code =
        pose_finder_.only_strangers() ? ReasonCode::kAmbiguousMotion : ReasonCode::kNotFoundAgain;
    const std::vector<Landmark> landmarks = keyframe_maker_.Look(left, right, vertical_.vertical_px());
    if (static_cast<int>(landmarks.size()) < 2 * config_.min_inliers) {
      pose.reason = "the images show too few features";
      pose.reason_code = ReasonCode::kFewFeatures;
      return pose;
    }
    for (const Keyframe& keyframe : window_.keyframes)
      archive_.Add(keyframe, window_.landmarks, keyframe_covariance_);
    const bool lost = Lost();
    const auto known = archive_.Recognize(left, landmarks, pose.T_world_left, lost ? num_strange_frames_ : 0,
                                          static_cast<std::uint32_t>(frame.frame_id));
    if (known && (lost ? known->num_inliers >= 2 * config_.min_inliers
                       : bridging_.CanReach(known->T_world_left, pose.T_world_left))) {
      pose.status = TrackingStatus::kTracking;
      pose.reason.clear();
      pose.reason_code = ReasonCode::kNone;
      pose.T_world_left = known->T_world_left;
      pose.T_prev_left = last_->T_world_left.inverse() * pose.T_world_left;
      pose.covariance = known->covariance;
      pose.num_inliers = known->num_inliers;
      witness_.Reset();
      Remember(pose);
    } else if (!lost && HasJumped(known, left, landmarks, pose)) {
      return Jumped(std::move(pose));
    } else if (++num_strange_frames_ < kMaxStrangeFrames) {
      return pose;
    }
    num_strange_frames_ = 0;
    // Feet may slip, an IMU may fail: where a sensor and the images have excluded each other, nobody knows.
    const bool contested = !contested_.isZero();
    if (contested && pose.status != TrackingStatus::kTracking) pose.covariance += contested_;
    if (!lost && contested && pose.status != TrackingStatus::kTracking) return pose;
    if (lost && pose.status != TrackingStatus::kTracking) return BeginAnew(frame, left, right, samples);
    const KeyframeState biases = window_.keyframes.back();
    window_ = {};
    AddKeyframe(frame, left, right, pose.T_world_left, {});
    window_.keyframes.back().gyro_bias = biases.gyro_bias;
    window_.keyframes.back().accel_bias = biases.accel_bias;
    window_.keyframes.back().velocity_world = motion_.imu_velocity_world();
    StartWindow(pose.covariance, BridgedImu());
    return pose;
  }

  /// What has been strange for some frames is a place known well, and far from where it can be.
  /// @param near  what was recognised nearby
  bool HasJumped(const std::optional<KeyframeArchive::Recognition>& near, const ImagePyramid& left,
                 const std::vector<Landmark>& landmarks, const PoseEstimate& pose) const {
    constexpr double kFar_m = 0.5;  // farther than a bridge of some frames leads astray
    if (num_strange_frames_ == 0) return false;
    const auto known = near ? near
                            : archive_.Recognize(left, landmarks, pose.T_world_left, num_strange_frames_,
                                                 static_cast<std::uint32_t>(pose.frame_id));
    return known && known->num_inliers >= 2 * config_.min_inliers &&
           (known->T_world_left.translation() - pose.T_world_left.translation()).norm() > kFar_m;
  }

  /// The camera was carried there, or the player of a recording was started again: what the IMU, the legs and
  /// the motion so far say about where it is now is nothing.
  PoseEstimate Jumped(PoseEstimate pose) {
    warnings_.push_back(
        "the images show a place that cannot have been reached: the view has jumped, or a recording begins "
        "anew");
    pose.status = TrackingStatus::kLost;
    pose.reason = warnings_.back();
    pose.reason_code = ReasonCode::kNotFoundAgain;
    bridging_.LoseTime();
    motion_.Lose();
    Remember(pose);
    return pose;
  }

  void Remember(const PoseEstimate& pose) {
    last_ = pose;
    if (pose.status != TrackingStatus::kTracking) return;
    bridging_.See(pose);
    contested_.setZero();
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
  ColumnMonitor columns_;
  RowChanges row_changes_;
  ImuCheck imu_check_;
  ImuWatch imu_watch_;
  TurnComparison turns_;
  StandingImages standing_;
  Bridging bridging_;
  Witness witness_;

  Window window_;
  Matrix6d keyframe_covariance_ = Matrix6d::Zero();  ///< of the newest keyframe against the first pose
  std::optional<PoseEstimate> last_;
  /// By how much images and a sensor have excluded each other since the last tracked frame.
  Matrix6d contested_ = Matrix6d::Zero();
  Matrix6d own_covariance_ = Matrix6d::Zero();  ///< of the last tracked frame against its keyframe
  bool frozen_ = false;                         ///< both cameras, since their images stand
  int epoch_ = 0;
  int num_incredible_ = 0;      ///< readings that no sensor can have made
  int num_strange_frames_ = 0;  ///< in a row, with features enough but none of the window's
  FrameSightings sightings_;    ///< of the last frame
  std::vector<std::string> warnings_;
};

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
void VisualOdometry::Apply(const GravityHint& hint) { impl_->Apply(hint); }

}  // namespace terrace
