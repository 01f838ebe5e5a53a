// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/visual_odometry.h"

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "odometry/covariance.h"
#include "odometry/imu_preintegration.h"
#include "odometry/rotation.h"

namespace terrace {
namespace {

const StereoCamera kCamera{320, 240, 200.0, 200.0, 159.5, 119.5, 0.12};
constexpr int kTextureSize = 512;

/// Stands upright in the way: all of its height, or every second strip of it.
struct Panel {
  double z_m = 0.0;
  double right_m = 0.0;                                     ///< edge
  double slat_m = std::numeric_limits<double>::infinity();  ///< height of its slats and of the gaps between
};

/// A floor 0.5 m below the camera and a wall 3 m ahead, both with smooth noise on them.
class TinyWorld {
 public:
  /// @param period_px  after which the texture repeats itself, a power of two
  explicit TinyWorld(int period_px = kTextureSize) : period_px_(period_px) {
    std::mt19937 random(1);
    cv::Mat1f noise(kTextureSize, kTextureSize);
    for (float& value : noise) value = static_cast<float>(random() % 1000) / 1000.0f;
    cv::Mat1f fine, coarse;
    cv::GaussianBlur(noise, fine, {}, 1.5, 1.5, cv::BORDER_REFLECT);
    cv::GaussianBlur(noise, coarse, {}, 8.0, 8.0, cv::BORDER_REFLECT);
    texture_ = 128.0f + 500.0f * (fine - 0.5f) + 2500.0f * (coarse - 0.5f);
  }

  void PutUp(const Panel& panel) { panel_ = panel; }

  cv::Mat1b View(const Eigen::Isometry3d& T_start_camera, double gain = 1.0) const {
    cv::Mat1b image(kCamera.height, kCamera.width);
    const Eigen::Vector3d eye = T_start_camera.translation();
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector3d ray =
            T_start_camera.linear() *
            Eigen::Vector3d((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy, 1.0);
        const double to_floor = ray.y() > 1e-6 ? (0.5 - eye.y()) / ray.y() : 1e9;
        const double to_wall = ray.z() > 1e-6 ? (3.0 - eye.z()) / ray.z() : 1e9;
        const Eigen::Vector3d p = eye + std::min(to_floor, to_wall) * ray;
        const double grey =
            to_floor < to_wall ? Grey(p.x() * 150.0, p.z() * 150.0) : Grey(p.x() * 60.0 + 99.0, p.y() * 60.0);
        if (const auto on_panel = HitPanel(eye, ray, std::min(to_floor, to_wall))) {
          image(v, u) = cv::saturate_cast<std::uint8_t>(
              gain * Grey(on_panel->x() * 150.0 + 300.0, on_panel->y() * 150.0));
          continue;
        }
        image(v, u) = cv::saturate_cast<std::uint8_t>(gain * grey);
      }
    }
    return image;
  }

  StereoFrame Frame(FrameId id, const Eigen::Isometry3d& T_start_left, double gain = 1.0) const {
    StereoFrame frame;
    frame.frame_id = id;
    frame.t_capture = Timestamp{1'000'000'000 + id * 66'000'000};
    frame.left = View(T_start_left, gain);
    frame.right = View(T_start_left * Eigen::Translation3d(kCamera.baseline_m, 0, 0), gain);
    return frame;
  }

 private:
  std::optional<Eigen::Vector3d> HitPanel(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray,
                                          double to_next) const {
    if (!panel_ || ray.z() < 1e-6) return std::nullopt;
    const double to_panel = (panel_->z_m - eye.z()) / ray.z();
    const Eigen::Vector3d p = eye + to_panel * ray;
    const bool hit =
        to_panel > 0 && to_panel < to_next && p.x() < panel_->right_m &&
        (std::isinf(panel_->slat_m) || std::fmod(p.y() + 100.0, 2 * panel_->slat_m) < panel_->slat_m);
    return hit ? std::optional(p) : std::nullopt;
  }
  double Grey(double x, double y) const {
    const double fx = x - std::floor(x), fy = y - std::floor(y);
    const int ix = static_cast<int>(std::floor(x)) & (period_px_ - 1),
              iy = static_cast<int>(std::floor(y)) & (period_px_ - 1);
    const int jx = (ix + 1) & (period_px_ - 1), jy = (iy + 1) & (period_px_ - 1);
    return (1 - fy) * ((1 - fx) * texture_(iy, ix) + fx * texture_(iy, jx)) +
           fy * ((1 - fx) * texture_(jy, ix) + fx * texture_(jy, jx));
  }
  int period_px_;
  cv::Mat1f texture_;
  std::optional<Panel> panel_;
};

const TinyWorld& World() {
  static const TinyWorld world;
  return world;
}

/// A bouncing walk: 2.5 cm a frame, with turns.
Eigen::Isometry3d Walk(double frame) {
  Vector6d step;
  step << 0.02 * std::sin(0.9 * frame), 0.03 * std::sin(0.3 * frame), 0.01 * std::sin(0.5 * frame),
      0.01 * std::sin(0.4 * frame), 0.015 * std::sin(1.1 * frame), 0.025 * frame;
  return Perturb(Eigen::Isometry3d::Identity(), step);
}

Eigen::Isometry3d FromStart(const PoseEstimate& first, const PoseEstimate& pose) {
  return first.T_world_left.inverse() * pose.T_world_left;
}

constexpr double kFrame_s = 0.066;
constexpr std::int64_t kFrame_ns = 66'000'000;

/// What an IMU in the left camera measures on the walk between a frame and the one before; y is down.
SensorSamples ImuUpTo(int frame) {
  constexpr int kSamples = 13;
  SensorSamples samples;
  for (int k = 1; k <= kSamples; ++k) {
    const double at = frame - 1 + static_cast<double>(k) / kSamples;
    constexpr double kStep = 0.01;  // frames
    const Eigen::Isometry3d before = Walk(at - kStep), now = Walk(at), after = Walk(at + kStep);
    ImuSample sample;
    sample.t = Timestamp{1'000'000'000 + std::llround(at * static_cast<double>(kFrame_ns))};
    sample.gyro = LogRotation(before.linear().transpose() * after.linear()) / (2 * kStep * kFrame_s);
    const Eigen::Vector3d acceleration =
        (after.translation() - 2 * now.translation() + before.translation()) / std::pow(kStep * kFrame_s, 2);
    sample.accel = now.linear().transpose() * (acceleration - kGravityMagnitude * Eigen::Vector3d::UnitY());
    samples.imu.push_back(sample);
  }
  return samples;
}

/// An IMU that sits in the left camera, and its noise.
Mounting WithImu() {
  Mounting mounting;
  mounting.T_left_imu = Eigen::Isometry3d::Identity();
  mounting.imu_noise = {1e-3, 1e-5, 1e-2, 1e-4};
  return mounting;
}

/// The same samples with the noise that WithImu() claims.
SensorSamples WithNoise(SensorSamples samples, std::mt19937& random) {
  const double root_rate = std::sqrt(static_cast<double>(samples.imu.size()) / kFrame_s);
  std::normal_distribution<double> normal;
  for (ImuSample& sample : samples.imu) {
    for (int axis = 0; axis < 3; ++axis) {
      sample.gyro[axis] += WithImu().imu_noise.gyro_density * root_rate * normal(random);
      sample.accel[axis] += WithImu().imu_noise.accel_density * root_rate * normal(random);
    }
  }
  return samples;
}

/// Body x forward, y left, z up, in the camera's place.
Mounting WithBody() {
  Mounting mounting;
  mounting.T_body_left = Eigen::Isometry3d::Identity();
  mounting.T_body_left->linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return mounting;
}

/// What body attitude or legs say at a frame: true, in an odometry frame of their own that was turned at
/// will.
BodyPrior PriorAt(int frame, PriorKind kind) {
  const Eigen::Isometry3d T_body_left = *WithBody().T_body_left;
  BodyPrior prior;
  prior.t = Timestamp{1'000'000'000 + frame * kFrame_ns};
  prior.kind = kind;
  prior.T_odom_body = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(3, -2, 1) *
                      T_body_left * Walk(frame) * T_body_left.inverse();
  prior.covariance.diagonal().setConstant(1e-6);
  return prior;
}

StereoFrame Black(StereoFrame frame) {
  frame.left.setTo(2);
  frame.right.setTo(2);
  return frame;
}

double ErrorMm(const PoseEstimate& first, const PoseEstimate& pose, int frame) {
  return 1e3 *
         (FromStart(first, pose).translation() - (Walk(0).inverse() * Walk(frame)).translation()).norm();
}

TEST(VisualOdometryTest, TellsWhatBecameOfTheLandmarks) {
  VisualOdometry odometry({}, kCamera, {});
  odometry.Track(World().Frame(0, Walk(0)), {});
  EXPECT_TRUE(odometry.sightings().is_keyframe);
  std::map<std::int64_t, Eigen::Vector2f> created;
  for (const LandmarkSighting& sighting : odometry.sightings().landmarks) {
    EXPECT_EQ(sighting.fate, LandmarkFate::kCreated);
    created[sighting.landmark] = sighting.pixel;
  }
  ASSERT_GT(created.size(), 50u);
  // From where it stands: every landmark is where it began.
  const PoseEstimate pose = odometry.Track(World().Frame(1, Walk(0)), {});
  EXPECT_FALSE(odometry.sightings().is_keyframe);
  int num_agree = 0;
  for (const LandmarkSighting& sighting : odometry.sightings().landmarks) {
    if (sighting.fate != LandmarkFate::kAgrees) continue;
    ++num_agree;
    ASSERT_TRUE(created.contains(sighting.landmark));
    EXPECT_LT((sighting.pixel - created[sighting.landmark]).norm(), 0.2F);
  }
  EXPECT_EQ(num_agree, pose.num_inliers);
  odometry.Bridge(2, Timestamp{1'132'000'000}, {}, "no image");
  EXPECT_TRUE(odometry.sightings().landmarks.empty());
}

TEST(VisualOdometryTest, FollowsABouncingWalkToAMillimetre) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 24; ++i) {
    const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(i)), {});
    ASSERT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i << ": " << pose.reason;
    if (i == 0) {
      first = pose;
      EXPECT_TRUE(pose.covariance.isZero());
    }
    EXPECT_LT(ErrorMm(first, pose, i), 2.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, BridgesBlackFramesAndSaysSoAndFindsBack) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first, pose;
  double sigma_before = 0.0;
  for (int i = 0; i < 20; ++i) {
    StereoFrame frame = World().Frame(i, Walk(i));
    const bool black = i >= 12 && i < 16;
    if (black) {
      frame.left.setTo(2);
      frame.right.setTo(2);
    }
    pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, black ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
    EXPECT_EQ(pose.reason.empty(), !black);
    EXPECT_EQ(pose.trusted, !black);
    if (black) {
      EXPECT_GT(pose.covariance(5, 5), sigma_before) << "frame " << i;
    }
    sigma_before = pose.covariance(5, 5);
  }
  EXPECT_LT(ErrorMm(first, pose, 19), 3.0);
}

TEST(VisualOdometryTest, KnowsWithAnImuWhereDownIsAndWalksOnThroughTheDark) {
  VisualOdometry odometry({}, kCamera, WithImu());
  PoseEstimate first;
  for (int i = 0; i < 30; ++i) {
    const StereoFrame frame = World().Frame(i, Walk(i));
    const bool black = i >= 20 && i < 26;
    const PoseEstimate pose = odometry.Track(black ? Black(frame) : frame, ImuUpTo(i));
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, black ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
    EXPECT_LT(ErrorMm(first, pose, i), black ? 15.0 : 2.0) << "frame " << i;
  }
  EXPECT_EQ(odometry.gravity().source, GravitySource::kImu);
  const Eigen::Vector3d down_left = first.T_world_left.linear().transpose() * odometry.gravity().down_world;
  EXPECT_LT(std::acos(down_left.dot(Walk(0).linear().transpose() * Eigen::Vector3d::UnitY())), 0.02);
}

/// Mean normalised error squared (6 is honest) of frames that were bridged through gaps of one to five
/// frames.
double BridgingNees(bool with_imu) {
  VisualOdometry odometry({}, kCamera, with_imu ? WithImu() : Mounting{});
  std::mt19937 random(3);
  PoseEstimate first;
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 70; ++i) {
    constexpr int kEvery = 10;
    const bool black = i >= 20 && i % kEvery < i / kEvery - 1;
    const StereoFrame frame = World().Frame(i, Walk(i));
    const PoseEstimate pose = odometry.Track(black ? Black(frame) : frame,
                                             with_imu ? WithNoise(ImuUpTo(i), random) : SensorSamples{});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, black ? TrackingStatus::kBridging : TrackingStatus::kTracking) << "frame " << i;
    if (!black) continue;
    const Vector6d error = StepBetween(Walk(0).inverse() * Walk(i), FromStart(first, pose));
    sum += Chi2(error, pose.covariance);
    ++count;
  }
  return sum / count;
}

TEST(VisualOdometryTest, KnowsHowWrongItIsWhileItBridges) {
  for (const bool with_imu : {false, true}) {
    const double nees = BridgingNees(with_imu);
    EXPECT_GT(nees, 1.0) << (with_imu ? "with IMU" : "without IMU");
    EXPECT_LT(nees, 12.0) << (with_imu ? "with IMU" : "without IMU");
  }
}

TEST(VisualOdometryTest, DoesWithoutAnImuThatTurnsOtherwiseThanTheImages) {
  VisualOdometry odometry({}, kCamera, WithImu());
  PoseEstimate first;
  for (int i = 0; i < 40; ++i) {
    SensorSamples samples = ImuUpTo(i);
    for (ImuSample& sample : samples.imu) sample.gyro.y() += 2.0;
    const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(i)), samples);
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i;
    EXPECT_LT(ErrorMm(first, pose, i), 20.0) << "frame " << i;
  }
  ASSERT_EQ(odometry.warnings().size(), 1u);
  EXPECT_NE(odometry.warnings()[0].find("IMU"), std::string::npos);
}

TEST(VisualOdometryTest, TakesUpFromTheBodysAttitudeUnlessToldNotTo) {
  for (const bool use_priors : {true, false}) {
    OdometryConfig config;
    config.use_priors = use_priors;
    VisualOdometry odometry(config, kCamera, WithBody());
    for (int i = 0; i < 6; ++i) {
      SensorSamples samples;
      samples.priors.push_back(PriorAt(i, PriorKind::kAttitude));
      const PoseEstimate pose = odometry.Track(World().Frame(i, Walk(i)), samples);
      const Eigen::Vector3d down_left =
          pose.T_world_left.linear().transpose() * odometry.gravity().down_world;
      if (use_priors) {
        EXPECT_LT(std::acos(down_left.dot(Walk(i).linear().transpose() * Eigen::Vector3d::UnitY())), 0.003);
      }
    }
    EXPECT_EQ(odometry.gravity().source, use_priors ? GravitySource::kAttitude : GravitySource::kMounting);
  }
}

TEST(VisualOdometryTest, FollowsTheLegsThroughTheDark) {
  double error_mm[2];
  for (const bool use_priors : {true, false}) {
    OdometryConfig config;
    config.use_priors = use_priors;
    VisualOdometry odometry(config, kCamera, WithBody());
    PoseEstimate first, pose;
    for (int i = 0; i < 16; ++i) {
      SensorSamples samples;
      samples.priors.push_back(PriorAt(i, PriorKind::kLegOdometry));
      const StereoFrame frame = World().Frame(i, Walk(i));
      pose = odometry.Track(i < 10 ? frame : Black(frame), samples);
      if (i == 0) first = pose;
    }
    EXPECT_EQ(pose.status, TrackingStatus::kBridging);
    error_mm[use_priors] = ErrorMm(first, pose, 15);
  }
  EXPECT_LT(error_mm[true], 3.0);
  EXPECT_GT(error_mm[false], 10.0);
}

TEST(VisualOdometryTest, IsLostAfterBridgingTooLongAndFindsBackToItsKeyframes) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first, pose;
  for (int i = 0; i < 8; ++i) {
    pose = odometry.Track(World().Frame(i, Walk(i)), {});
    if (i == 0) first = pose;
  }
  for (int i = 8; i < 50; ++i)
    pose = odometry.Bridge(i, Timestamp{1'000'000'000 + i * 66'000'000ll}, {}, "the image cannot be read");
  EXPECT_EQ(pose.status, TrackingStatus::kLost);
  EXPECT_EQ(pose.reason, "the image cannot be read");
  StereoFrame frame = World().Frame(50, Walk(8));
  pose = odometry.Track(frame, {});
  EXPECT_EQ(pose.status, TrackingStatus::kTracking);
  EXPECT_LT(ErrorMm(first, pose, 8), 3.0);
}

/// A textured board at 0.5 m that swings through the view and covers a third of it, unless told otherwise.
void HoldBoardInto(StereoFrame& frame, double width_share = 0.5, double height_share = 2.0 / 3.0) {
  constexpr int kDisparityPx = 48;
  const auto i = static_cast<double>(frame.frame_id);
  const int width = static_cast<int>(kCamera.width * width_share);
  const int height = static_cast<int>(kCamera.height * height_share);
  const int u0 = static_cast<int>((kCamera.width - width) * (0.5 + 0.5 * std::sin(0.11 * i)));
  const int v0 = static_cast<int>((kCamera.height - height) * (0.5 + 0.5 * std::sin(0.23 * i)));
  cv::Mat1b board(height / 4, width / 4), large;
  std::mt19937 random(7);
  for (std::uint8_t& grey : board) grey = static_cast<std::uint8_t>(60 + random() % 128);
  cv::resize(board, large, {width, height}, 0, 0, cv::INTER_CUBIC);
  large.copyTo(frame.left(cv::Rect(u0, v0, width, height)));
  const int u_right = std::max(u0 - kDisparityPx, 0);
  const int hidden = u_right - (u0 - kDisparityPx);
  large.colRange(hidden, width).copyTo(frame.right(cv::Rect(u_right, v0, width - hidden, height)));
}

TEST(VisualOdometryTest, IsNotCarriedAwayByABoardThatMovesThroughTheView) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 45; ++i) {
    StereoFrame frame = World().Frame(i, Walk(i));
    if (i >= 8) HoldBoardInto(frame);
    const PoseEstimate pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    if (pose.status == TrackingStatus::kTracking) {
      EXPECT_LT(ErrorMm(first, pose, i), 4.0) << "frame " << i;
    }
  }
}

TEST(VisualOdometryTest, PublishesNoJumpAsCertainWhenItStumblesBeforeAMovingBoard) {
  int num_doubtful = 0;
  for (const int stumble : {18, 22, 26, 30, 34}) {
    VisualOdometry odometry({}, kCamera, {});
    PoseEstimate first;
    for (int i = 0; i < stumble + 8; ++i) {
      constexpr double kFramesFarther = 3.0;  // 7.5 cm at once, which no motion model expects
      const double at = i >= stumble ? i + kFramesFarther : i;
      StereoFrame frame = World().Frame(i, Walk(at));
      if (i >= 8) HoldBoardInto(frame, 0.65, 0.8);
      const PoseEstimate pose = odometry.Track(frame, {});
      if (i == 0) first = pose;
      const Vector6d error = StepBetween(Walk(0).inverse() * Walk(at), FromStart(first, pose));
      if (pose.trusted) {
        EXPECT_LT(1e3 * error.tail<3>().norm(), 4.0) << "stumbles at " << stumble << ", frame " << i;
      } else {
        EXPECT_LT(Chi2(error, pose.covariance), 20.0) << "stumbles at " << stumble << ", frame " << i;
      }
      num_doubtful += pose.status == TrackingStatus::kTracking && !pose.trusted;
    }
  }
  EXPECT_GT(num_doubtful, 0);
}

TEST(VisualOdometryTest, FollowsAJerkOfTheHeadWhereTextureRepeatsItself) {
  const TinyWorld repeating(64);
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 16; ++i) {
    Vector6d jerk = Vector6d::Zero();
    if (i >= 12) jerk[0] = 0.3;  // 60 px at once: farther than patches are followed
    const Eigen::Isometry3d T_start_left = Perturb(Walk(i), jerk);
    const PoseEstimate pose = odometry.Track(repeating.Frame(i, T_start_left), {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i;
    const Vector6d error = StepBetween(Walk(0).inverse() * T_start_left, FromStart(first, pose));
    EXPECT_LT(1e3 * error.tail<3>().norm(), 4.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, BelievesWhatIsNewWhereItHidesWhatIsKnown) {
  TinyWorld world;
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 24; ++i) {
    if (i == 12) world.PutUp({.z_m = 1.2, .right_m = 0.25});  // stands still from then on
    const PoseEstimate pose = odometry.Track(world.Frame(i, Walk(i)), {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i << ": " << pose.reason;
    EXPECT_LT(ErrorMm(first, pose, i), 4.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, FollowsAJerkBeforeSlats) {
  TinyWorld world;
  world.PutUp({.z_m = 1.0, .right_m = 10.0, .slat_m = 0.06});
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 16; ++i) {
    Vector6d jerk = Vector6d::Zero();
    if (i >= 12)
      jerk << 0.25, 0.0, 0.0, 0.0, 0.1, 0.0;  // 10 cm down, where coarse patches mix slats and gaps
    const Eigen::Isometry3d T_start_left = Perturb(Walk(i), jerk);
    const PoseEstimate pose = odometry.Track(world.Frame(i, T_start_left), {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i << ": " << pose.reason;
    const Vector6d error = StepBetween(Walk(0).inverse() * T_start_left, FromStart(first, pose));
    EXPECT_LT(1e3 * error.tail<3>().norm(), 4.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, FindsTheWayAfterAGapInWhichTheCameraWalkedOn) {
  VisualOdometry odometry({}, kCamera, {});
  PoseEstimate first, pose;
  for (int i = 0; i < 26; ++i) {
    if (i >= 12 && i < 22) continue;
    pose = odometry.Track(World().Frame(i, Walk(i)), {});
    if (i == 0) first = pose;
  }
  EXPECT_EQ(pose.status, TrackingStatus::kTracking);
  EXPECT_LT(ErrorMm(first, pose, 25), 4.0);
}

TEST(VisualOdometryTest, WalksOnWithItsOldLandmarksWhileTheRightImageIsLost) {
  OdometryConfig config;
  config.window_keyframes = 3;  // so that new ones would soon drive out the old
  config.keyframe_parallax = 0.01;
  VisualOdometry odometry(config, kCamera, {});
  PoseEstimate first;
  for (int i = 0; i < 40; ++i) {
    StereoFrame frame = World().Frame(i, Walk(i));
    if (i >= 16 && i < 32) frame.right.setTo(3);
    const PoseEstimate pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    EXPECT_EQ(pose.status, TrackingStatus::kTracking) << "frame " << i;
    EXPECT_LT(ErrorMm(first, pose, i), 4.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, StandsStillUnderNoiseAndChangingExposure) {
  VisualOdometry odometry({}, kCamera, {});
  std::mt19937 random(2);
  PoseEstimate first;
  for (int i = 0; i < 12; ++i) {
    StereoFrame frame = World().Frame(i, Walk(0), 1.0 + 0.3 * std::sin(i));
    for (cv::Mat1b* image : {&frame.left, &frame.right})
      for (std::uint8_t& grey : *image)
        grey = cv::saturate_cast<std::uint8_t>(grey + static_cast<int>(random() % 7) - 3);
    const PoseEstimate pose = odometry.Track(frame, {});
    if (i == 0) first = pose;
    EXPECT_LT(ErrorMm(first, pose, 0), 1.0) << "frame " << i;
  }
}

TEST(VisualOdometryTest, GivesTheSameBitsForAnyNumberOfThreads) {
  std::vector<Eigen::Matrix4d> poses[2];
  for (int run = 0; run < 2; ++run) {
    cv::setNumThreads(run == 0 ? 1 : 3);
    VisualOdometry odometry({}, kCamera, {});
    for (int i = 0; i < 8; ++i)
      poses[run].push_back(odometry.Track(World().Frame(i, Walk(i)), {}).T_world_left.matrix());
  }
  cv::setNumThreads(-1);
  EXPECT_EQ(poses[0], poses[1]);
}

TEST(VisualOdometryTest, WaitsForSomethingToSee) {
  VisualOdometry odometry({}, kCamera, {});
  StereoFrame black = World().Frame(0, Walk(0));
  black.left.setTo(0);
  black.right.setTo(0);
  const PoseEstimate nothing = odometry.Track(black, {});
  EXPECT_EQ(nothing.status, TrackingStatus::kLost);
  EXPECT_FALSE(nothing.reason.empty());
  EXPECT_EQ(odometry.Track(World().Frame(1, Walk(0)), {}).status, TrackingStatus::kTracking);
}

TEST(VisualOdometryTest, TakesUpFromPlanesOnlyWhenNothingBetterIsKnown) {
  VisualOdometry odometry({}, kCamera, {});
  odometry.Track(World().Frame(0, Walk(0)), {});
  EXPECT_EQ(odometry.gravity().source, GravitySource::kAssumed);
  GravityHint hint;
  hint.down_world = Eigen::Vector3d(0.1, 0.0, -1.0).normalized();
  hint.sigma_rad = 0.01;
  odometry.Apply(hint);
  EXPECT_EQ(odometry.gravity().source, GravitySource::kPlane);
  EXPECT_TRUE(odometry.gravity().down_world.isApprox(hint.down_world));
  GravityHint worse = hint;
  worse.down_world = -Eigen::Vector3d::UnitZ();
  worse.sigma_rad = 0.1;
  odometry.Apply(worse);
  EXPECT_TRUE(odometry.gravity().down_world.isApprox(hint.down_world));
}

TEST(VisualOdometryTest, NamesTheCalibrationWhenTheRightImageLiesLower) {
  VisualOdometry odometry({}, kCamera, {});
  StereoFrame frame = World().Frame(0, Walk(0));
  cv::Mat lower;
  cv::copyMakeBorder(frame.right.rowRange(0, frame.right.rows - 1), lower, 1, 0, 0, 0, cv::BORDER_REPLICATE);
  frame.right = lower;
  for (int i = 0; i < 60; ++i) {
    frame.frame_id = i;
    frame.t_capture = Timestamp{1'000'000'000 + i * 66'000'000ll};
    odometry.Track(frame, {});
  }
  ASSERT_EQ(odometry.warnings().size(), 1u);
  EXPECT_NE(odometry.warnings()[0].find("calibrat"), std::string::npos);
}

}  // namespace
}  // namespace terrace
