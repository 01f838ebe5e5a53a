// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/region_codec.h"
#include "lcmtypes/sensor_codec.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/terrain_codec.h"
#include "test/lcmtypes/example_maps.h"
#include "test/lcmtypes/over_memq.h"

namespace terrace {
namespace {

using testing::ElementsAre;

// Outlines travel as float in a frame of their own; 1 m in float is good to 6e-8.
constexpr double kFloatM = 1e-6;
constexpr double kFloatRelative = 1e-6;

Eigen::Isometry3d SomePose(double angle) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
  return pose;
}

void ExpectSameRegion(const TerrainRegion& a, const TerrainRegion& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.label, b.label);
  EXPECT_NEAR(a.confidence, b.confidence, kFloatRelative);
  EXPECT_NEAR((a.plane_world.normal - b.plane_world.normal).norm(), 0.0, 1e-12);
  EXPECT_NEAR(a.plane_world.offset_m, b.plane_world.offset_m, 1e-12);
  EXPECT_TRUE(a.plane_covariance.isApprox(b.plane_covariance, kFloatRelative));
  EXPECT_NEAR(a.rms_m, b.rms_m, kFloatM);
  EXPECT_NEAR(a.area_m2, b.area_m2, kFloatM);
  EXPECT_NEAR(a.support, b.support, kFloatRelative);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.why, b.why);
  EXPECT_NEAR((a.centroid_world - b.centroid_world).norm(), 0.0, 1e-9);
  EXPECT_EQ(a.num_observations, b.num_observations);
  EXPECT_EQ(a.first_seen, b.first_seen);
  EXPECT_EQ(a.last_seen, b.last_seen);
  EXPECT_EQ(a.staircase_id, b.staircase_id);
  EXPECT_EQ(a.step_index, b.step_index);
  const auto expect_same_ring = [](const Ring& ring_a, const Ring& ring_b) {
    ASSERT_EQ(ring_a.size(), ring_b.size());
    for (std::size_t i = 0; i < ring_a.size(); ++i) EXPECT_NEAR((ring_a[i] - ring_b[i]).norm(), 0.0, kFloatM);
  };
  expect_same_ring(a.outline_world, b.outline_world);
  ASSERT_EQ(a.holes_world.size(), b.holes_world.size());
  for (std::size_t i = 0; i < a.holes_world.size(); ++i) expect_same_ring(a.holes_world[i], b.holes_world[i]);
}

TEST(CodecTest, GivesThePoseOfTheBodyWithItsVelocities) {
  // The body turns left and drives forward; the camera sits ahead of it, looking along its x.
  PoseEstimate pose;
  pose.t_capture = {1600000000100000000};
  pose.status = TrackingStatus::kTracking;
  Eigen::Isometry3d T_body_left = Eigen::Isometry3d::Identity();
  T_body_left.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T_body_left.translation() = Eigen::Vector3d(0.3, 0.0, 0.1);
  Eigen::Isometry3d T_prev_body = Eigen::Isometry3d::Identity();
  T_prev_body.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_prev_body.translation() = Eigen::Vector3d(0.05, 0.0, 0.0);
  pose.T_prev_left = T_body_left.inverse() * T_prev_body * T_body_left;
  pose.T_world_left = SomePose(0.5) * T_body_left;

  const auto message = OverMemq(ToPoseMessage(pose, T_body_left, Timestamp{1600000000000000000}));
  ASSERT_TRUE(message);
  EXPECT_EQ(message->utime, 1600000000100000);
  const auto T_world_body = FromMessage(*message);
  ASSERT_TRUE(T_world_body);
  EXPECT_TRUE(T_world_body->isApprox(SomePose(0.5), 1e-12));
  EXPECT_NEAR(message->vel[0], 0.5, 1e-3);
  EXPECT_NEAR(message->vel[2], 0.0, 1e-9);
  EXPECT_NEAR(message->rotation_rate[2], 0.2, 1e-9);
}

TEST(CodecTest, CarriesTheBodysPoseWithWhatIsKnownOfIt) {
  PoseEstimate pose;
  pose.t_capture = {1600000000100000123};
  pose.status = TrackingStatus::kBridging;
  pose.reason = "dark";
  pose.reason_code = ReasonCode::kFewFeatures;
  pose.epoch = 3;
  pose.T_world_left = SomePose(0.5);
  pose.covariance = Matrix6d::Identity();
  const BodyPose body = BodyPoseOf(pose, SomePose(1.0), Timestamp{1600000000000000000}, 77);
  const auto message = OverMemq(ToMessage(body));
  ASSERT_TRUE(message);
  EXPECT_EQ(message->reason_code, pose_v1_t::REASON_FEW_FEATURES);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->t_capture, pose.t_capture);
  EXPECT_EQ(back->map_id, 77);
  EXPECT_EQ(back->epoch, 3);
  EXPECT_EQ(back->status, TrackingStatus::kBridging);
  EXPECT_EQ(back->reason_code, ReasonCode::kFewFeatures);
  EXPECT_EQ(back->reason, "dark");
  ASSERT_TRUE(back->T_world_body);
  EXPECT_TRUE(back->T_world_body->isApprox(pose.T_world_left * SomePose(1.0).inverse(), 1e-12));
  EXPECT_EQ(back->covariance, body.covariance);
  ASSERT_TRUE(back->velocity);
  EXPECT_EQ(back->velocity->linear_body, body.velocity->linear_body);
}

TEST(CodecTest, GivesNoPoseAndNoVelocityWhereNoneIsKnown) {
  PoseEstimate pose;
  pose.t_capture = {1600000000100000000};
  pose.status = TrackingStatus::kLost;
  pose.reason = "a sentence without a code";
  const auto message = OverMemq(ToMessage(BodyPoseOf(pose, SomePose(1.0), Timestamp{1}, 0)));
  ASSERT_TRUE(message);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_FALSE(back->T_world_body);
  EXPECT_FALSE(back->velocity);
  EXPECT_EQ(back->reason_code, ReasonCode::kOther);
}

TEST(CodecTest, GivesTheCovarianceOfTheBodyAsErrorsOfTheCameraMoveIt) {
  // The error of the body is found by moving the camera a little along each axis, one after the other.
  const Eigen::Isometry3d T_body_left = SomePose(1.3);
  PoseEstimate pose;
  pose.status = TrackingStatus::kTracking;
  pose.T_world_left = SomePose(0.4);
  Matrix6d root = Matrix6d::Zero();
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = 0.1 * ((i * 7) % 11 - 5);
  pose.covariance = root * root.transpose();
  constexpr double kStep = 1e-6;
  const Eigen::Isometry3d T_world_body = pose.T_world_left * T_body_left.inverse();
  Matrix6d moved = Matrix6d::Zero();
  for (int axis = 0; axis < 6; ++axis) {
    Vector6d error = Vector6d::Zero();
    error[axis] = kStep;
    Eigen::Isometry3d wrong = pose.T_world_left;
    wrong.translate(Eigen::Vector3d(error.tail<3>()));
    if (axis < 3) wrong.rotate(Eigen::AngleAxisd(kStep, Eigen::Vector3d::Unit(axis)));
    const Eigen::Isometry3d T_body_wrong = T_world_body.inverse() * (wrong * T_body_left.inverse());
    const Eigen::AngleAxisd turn(T_body_wrong.linear());
    moved.col(axis).head<3>() = turn.axis() * turn.angle() / kStep;
    moved.col(axis).tail<3>() = T_body_wrong.translation() / kStep;
  }
  const Matrix6d expected = moved * pose.covariance * moved.transpose();
  EXPECT_TRUE(BodyPoseOf(pose, T_body_left, std::nullopt, 0).covariance.isApprox(expected, 1e-4));
}

TEST(CodecTest, GivesTheMotionOfTheCameraWithItsCovariance) {
  PoseEstimate pose;
  pose.t_capture = {1600000000100000000};
  pose.status = TrackingStatus::kTracking;
  pose.T_prev_left = SomePose(0.1);
  for (int i = 0; i < 36; ++i) pose.covariance_prev(i / 6, i % 6) = i;
  const auto message = OverMemq(ToUpdateMessage(pose, Timestamp{1600000000000000000}));
  ASSERT_TRUE(message);
  EXPECT_EQ(message->timestamp, 1600000000100000);
  EXPECT_EQ(message->prev_timestamp, 1600000000000000);
  EXPECT_EQ(message->estimate_status, update_t::ESTIMATE_VALID);
  EXPECT_THAT(message->translation, ElementsAre(0.1, -0.2, 0.3));
  EXPECT_NEAR(message->rotation[0], std::cos(0.05), 1e-12) << "w comes first";
  EXPECT_EQ(message->covariance[1][2], 8.0);
  pose.status = TrackingStatus::kLost;
  EXPECT_EQ(ToUpdateMessage(pose, Timestamp{0}).estimate_status, update_t::NO_DATA);
}

TEST(CodecTest, CarriesImuSamplesExactly) {
  const ImuSample sample{{1600000000000000123}, {0.1, 0.2, 0.3}, {1.0 / 3.0, -9.81, 5e-300}};
  const auto message = OverMemq(ToMessage(sample));
  ASSERT_TRUE(message);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->t, sample.t);
  EXPECT_EQ(back->gyro, sample.gyro);
  EXPECT_EQ(back->accel, sample.accel);
}

TEST(CodecTest, CarriesBodyPriorsExactly) {
  BodyPrior prior{
      {1600000000000000123}, PriorKind::kAttitude, CanonicalPose(SomePose(1.0)), Matrix6d::Random()};
  const auto message = OverMemq(ToMessage(prior));
  ASSERT_TRUE(message);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->t, prior.t);
  EXPECT_EQ(back->kind, prior.kind);
  EXPECT_EQ(back->T_odom_body.matrix(), prior.T_odom_body.matrix());
  EXPECT_EQ(back->covariance, prior.covariance);
}

TEST(CodecTest, CarriesCalibrationsExactly) {
  StereoCalibration calibration;
  calibration.name = "bench";
  calibration.width = 752;
  calibration.height = 480;
  calibration.left = {
      458.654, 457.296, 367.215, 248.375, DistortionModel::kRadialTangential, {-0.28, 0.07, 1e-4, 2e-5}};
  calibration.right = {
      457.587, 456.134, 379.999, 255.238, DistortionModel::kRadialTangential, {-0.3, 0.1, 3e-4, 2e-5}};
  calibration.T_rawright_rawleft.linear() =
      Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).toRotationMatrix();
  calibration.T_rawright_rawleft.translation() = Eigen::Vector3d(-0.11, 0.001, -0.002);
  calibration.T_body_rawleft = CanonicalPose(SomePose(2.0));
  calibration.imu_noise = {1.0 / 3.0, 2e-5, 2e-3, 3e-3};
  const auto message = OverMemq(ToMessage(calibration, {1600000000000000000}));
  ASSERT_TRUE(message);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->name, calibration.name);
  EXPECT_EQ(back->width, calibration.width);
  EXPECT_EQ(back->height, calibration.height);
  for (const auto& [a, b] :
       {std::pair{back->left, calibration.left}, std::pair{back->right, calibration.right}}) {
    EXPECT_EQ(a.fx, b.fx);
    EXPECT_EQ(a.fy, b.fy);
    EXPECT_EQ(a.cx, b.cx);
    EXPECT_EQ(a.cy, b.cy);
    EXPECT_EQ(a.model, b.model);
    EXPECT_EQ(a.distortion, b.distortion);
  }
  EXPECT_EQ(back->T_rawright_rawleft.matrix(), calibration.T_rawright_rawleft.matrix());
  ASSERT_TRUE(back->T_body_rawleft);
  EXPECT_EQ(back->T_body_rawleft->matrix(), calibration.T_body_rawleft->matrix());
  EXPECT_FALSE(back->T_body_imu);
  EXPECT_EQ(back->imu_noise.gyro_density, calibration.imu_noise.gyro_density);
  EXPECT_EQ(back->imu_noise.accel_walk, calibration.imu_noise.accel_walk);
}

TEST(CodecTest, CarriesEveryLensModel) {
  for (int i = 0; i <= static_cast<int>(DistortionModel::kPolynomial); ++i) {
    StereoCalibration calibration;
    calibration.left = calibration.right = {400, 401, 320, 240, static_cast<DistortionModel>(i), {0.1, 0.2}};
    const auto back = FromMessage(ToMessage(calibration, {0}));
    ASSERT_TRUE(back) << i;
    EXPECT_EQ(back->left.model, calibration.left.model);
    EXPECT_EQ(back->right.distortion, calibration.right.distortion);
  }
}

TEST(CodecTest, ChangesTheHashOfACalibrationWithItsContentAlone) {
  StereoCalibration calibration;
  const std::string hash = ToMessage(calibration, {0}).content_hash;
  calibration.name = "other";
  EXPECT_EQ(ToMessage(calibration, {5000}).content_hash, hash);
  calibration.left.cx += 1e-9;
  EXPECT_NE(ToMessage(calibration, {0}).content_hash, hash);
}

TEST(CodecTest, CarriesTheStatus) {
  Status status;
  status.t = {1600000000000001000};
  status.seq = 7;
  status.version = "0.1.0";
  status.state = DaemonState::kNoCalibration;
  status.tracking = TrackingStatus::kBridging;
  status.gravity_source = GravitySource::kPlane;
  status.reason = "dark";
  status.num_imu_gaps = 3;
  status.fps_in = 14.5;
  status.reason_code = ReasonCode::kInputTrouble;
  status.map_id = 1600000000000123;
  status.map_seq = 12;
  status.epoch = 2;
  status.inputs = {{"imu", "TERRACE_IMU", 1000, 3, 200.5, 4.5},
                   {"images", "CAMERA", 0, 0, 0.0, std::nullopt}};
  status.stages = {{"disparity", 10, 9, 1, 2, 0.5, 1.5, 2.5, 3.5}, {"merging", 1, 1, 0, 0, 0, 0, 0, 0}};
  const auto message = OverMemq(ToMessage(status));
  ASSERT_TRUE(message);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->t, status.t);
  EXPECT_EQ(back->seq, 7);
  EXPECT_EQ(back->version, "0.1.0");
  EXPECT_EQ(back->state, DaemonState::kNoCalibration);
  EXPECT_EQ(back->tracking, TrackingStatus::kBridging);
  EXPECT_EQ(back->gravity_source, GravitySource::kPlane);
  EXPECT_EQ(back->reason, "dark");
  EXPECT_EQ(back->num_imu_gaps, 3);
  EXPECT_EQ(back->fps_in, 14.5);
  EXPECT_EQ(back->reason_code, ReasonCode::kInputTrouble);
  EXPECT_EQ(back->map_id, 1600000000000123);
  EXPECT_EQ(back->map_seq, 12);
  EXPECT_EQ(back->epoch, 2);
  ASSERT_EQ(back->inputs.size(), 2u);
  EXPECT_EQ(back->inputs[0].channel, "TERRACE_IMU");
  EXPECT_EQ(back->inputs[0].num_messages, 1000);
  EXPECT_EQ(back->inputs[0].num_bad, 3);
  EXPECT_EQ(back->inputs[0].rate_hz, 200.5);
  EXPECT_EQ(back->inputs[0].age_ms, 4.5);
  EXPECT_FALSE(back->inputs[1].age_ms) << "nothing has arrived";
  ASSERT_EQ(back->stages.size(), 2u);
  EXPECT_EQ(back->stages[0].queue_depth, 2);
  EXPECT_EQ(back->stages[0].name, "disparity");
  EXPECT_EQ(back->stages[0].num_dropped, 1);
  EXPECT_EQ(back->stages[0].p99_ms, 2.5);
}

TEST(CodecTest, CarriesRegionsOfEveryShape) {
  ExampleMaps maps(1);
  for (int i = 1; i <= 50; ++i) {
    const auto region = maps.Region(i, i);
    const auto message = OverMemq(ToMessage(*region, Gravity()));
    ASSERT_TRUE(message);
    const auto back = FromMessage(*message);
    ASSERT_TRUE(back);
    ExpectSameRegion(*back, *region);
  }
}

TEST(CodecTest, CutsALargeRegionIntoPiecesThatGiveItBackWhole) {
  constexpr std::size_t kPieceBytes = 400;
  ExampleMaps maps(8);
  int most_pieces = 0;
  for (int i = 1; i <= 50; ++i) {
    const auto region = maps.Region(i, i);
    const std::vector<region_v1_t> pieces = RegionPieces(*region, Gravity(), kPieceBytes);
    std::vector<const region_v1_t*> in_order;
    for (const region_v1_t& piece : pieces) {
      EXPECT_LE(static_cast<std::size_t>(piece._getEncodedSizeNoHash()), kPieceBytes);
      in_order.push_back(&piece);
    }
    most_pieces = std::max(most_pieces, static_cast<int>(pieces.size()));
    const auto back = RegionFromPieces(in_order);
    ASSERT_TRUE(back);
    ExpectSameRegion(*back, *region);
    if (pieces.size() == 1) continue;
    EXPECT_FALSE(FromMessage(pieces[0])) << "a piece is no region";
    std::reverse(in_order.begin(), in_order.end());
    EXPECT_FALSE(RegionFromPieces(in_order));
    in_order.pop_back();
    EXPECT_FALSE(RegionFromPieces(in_order));
  }
  EXPECT_GE(most_pieces, 3);
}

TEST(CodecTest, GivesTheHeightOfThePlaneAtItsOriginTheVarianceThatTheRegionHasAtItsCentroid) {
  ExampleMaps maps(9);
  const auto region = maps.Region(1, 1);
  const region_v1_t message = ToMessage(*region, Gravity());
  EXPECT_NEAR(
      (Eigen::Vector3d(message.origin[0], message.origin[1], message.origin[2]) - region->centroid_world)
          .norm(),
      0.0, 1e-9);
  EXPECT_NEAR(message.plane_cov[5], region->plane_covariance(2, 2), 1e-12);
  EXPECT_NEAR(message.plane_cov[2], region->plane_covariance(0, 2), 1e-12);
}

TEST(CodecTest, ReadsALabelThatItDoesNotKnowAsUnknown) {
  region_v1_t message = ToMessage(*ExampleMaps(10).Region(1, 1), Gravity());
  message.label = kNumTerrainLabels + 3;
  const auto region = FromMessage(message);
  ASSERT_TRUE(region);
  EXPECT_EQ(region->label, TerrainLabel::kUnknown);
}

TEST(CodecTest, MeasuresTheSlopeAgainstGravityNotAgainstZAndTellsCeilingsFromFloors) {
  TerrainRegion region;
  region.id = 1;
  Gravity gravity;
  gravity.down_world = Eigen::Vector3d(0.1, 0.0, -1.0).normalized();
  EXPECT_NEAR(ToMessage(region, gravity).slope, std::atan(0.1), 1e-6);
  region.plane_world.normal = -Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(ToMessage(region, gravity).slope, M_PI - std::atan(0.1), 1e-6);
}

TEST(CodecTest, CarriesStaircases) {
  const Staircase stairs = ExampleMaps(2).Stairs(3);
  const auto message = OverMemq(ToMessage(stairs));
  ASSERT_TRUE(message);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->id, 3);
  EXPECT_EQ(back->num_risers, stairs.num_risers);
  EXPECT_EQ(back->num_treads, stairs.num_treads);
  EXPECT_NEAR(back->riser_m, stairs.riser_m, kFloatM);
  EXPECT_NEAR(back->tread_m, stairs.tread_m, kFloatM);
  EXPECT_NEAR(back->width_m, stairs.width_m, kFloatM);
  EXPECT_EQ(back->foot_edge_world, stairs.foot_edge_world);
  EXPECT_EQ(back->head_edge_world, stairs.head_edge_world);
  EXPECT_TRUE(back->direction_up_world.isApprox(stairs.direction_up_world, kFloatRelative));
  EXPECT_EQ(back->last_seen, stairs.last_seen);
}

TEST(CodecTest, RefusesValuesThatCannotBeMeant) {
  ExampleMaps maps(3);
  const region_v1_t good = ToMessage(*maps.Region(1, 1), Gravity());
  ASSERT_TRUE(FromMessage(good));
  region_v1_t bad = good;
  bad.source = kNumRegionSources;
  EXPECT_FALSE(FromMessage(bad)) << "no such source";
  bad = good;
  bad.edge_kind[0] = kNumEdgeKinds;
  EXPECT_FALSE(FromMessage(bad)) << "no such kind of an edge";
  bad = good;
  bad.edge_step[0] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(FromMessage(bad)) << "no step is so high";
  bad = good;
  bad.continues = 1;
  EXPECT_FALSE(FromMessage(bad)) << "goes on with nothing";
  bad = good;
  bad.coords[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(FromMessage(bad)) << "not a number";
  bad = good;
  bad.ring_size[0] = std::numeric_limits<std::int32_t>::max();
  EXPECT_FALSE(FromMessage(bad)) << "more vertices than there are";
  bad = good;
  bad.quat[0] = bad.quat[1] = bad.quat[2] = bad.quat[3] = 0.0;
  EXPECT_FALSE(FromMessage(bad)) << "no rotation";
  bad = good;
  bad.last_utime = std::numeric_limits<std::int64_t>::max();
  EXPECT_FALSE(FromMessage(bad)) << "no time";

  imu_v1_t imu{};
  imu.gyro[2] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(FromMessage(imu));
  body_prior_v1_t prior = ToMessage(BodyPrior());
  prior.kind = 3;
  EXPECT_FALSE(FromMessage(prior));
  calibration_v1_t calibration = ToMessage(StereoCalibration(), {0});
  calibration.model = "fisheye";
  EXPECT_FALSE(FromMessage(calibration));
  status_v1_t status{};
  status.state = -1;
  EXPECT_FALSE(FromMessage(status));
}

TEST(TerrainMessagesTest, CutsASnapshotIntoPartsBelowTheLimitThatHoldEveryRegionOnce) {
  const TerrainMap map = ExampleMaps(4).First(300);
  const std::vector<terrain_v1_t> parts = SnapshotMessages(map);
  EXPECT_GT(parts.size(), 5u);
  std::set<std::int64_t> ids;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_LE(parts[i].getEncodedSize(), static_cast<int>(kMaxTerrainMessageBytes));
    EXPECT_EQ(parts[i].kind, terrain_v1_t::SNAPSHOT);
    EXPECT_EQ(parts[i].part, static_cast<int>(i));
    EXPECT_EQ(parts[i].n_parts, static_cast<int>(parts.size()));
    EXPECT_EQ(parts[i].seq, map.seq);
    for (const region_v1_t& region : parts[i].regions)
      EXPECT_EQ(ids.insert(region.id).second, region.piece == 0);
  }
  EXPECT_EQ(ids.size(), 300u);
}

TEST(TerrainMessagesTest, SendsAnEmptyMapAsOnePart) {
  const std::vector<terrain_v1_t> parts = SnapshotMessages(TerrainMap());
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_TRUE(OverMemq(parts[0]));
}

TEST(TerrainMessagesTest, SendsOnlyWhatChangedInADelta) {
  ExampleMaps maps(5);
  const TerrainMap base = maps.First(5);
  TerrainMap map = base;
  ++map.seq;
  map.regions[1] = maps.Region(2, 9);
  map.regions.erase(map.regions.begin() + 3);
  map.staircases[0].riser_m += 0.01;
  const std::vector<terrain_v1_t> parts = DeltaMessages(base, map, 20000);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].kind, terrain_v1_t::DELTA);
  EXPECT_EQ(parts[0].base_seq, base.seq);
  EXPECT_EQ(parts[0].seq, map.seq);
  EXPECT_THAT(parts[0].removed_ids, ElementsAre(4));
  ASSERT_EQ(parts[0].n_regions, 1);
  EXPECT_EQ(parts[0].regions[0].id, 2);
  EXPECT_EQ(parts[0].n_staircases, 1);
}

TEST(TerrainMessagesTest, CarriesWhatAMapSaysBesideItsRegions) {
  TerrainMap map = ExampleMaps(6).First(1);
  map.t_capture.ns += 123;
  map.epoch = 4;
  map.T_body_left = CanonicalPose(SomePose(0.7));
  const auto message = OverMemq(TerrainHead(map, map.T_body_left));
  ASSERT_TRUE(message);
  const auto back = FromMessage(*message);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->t_capture, map.t_capture);
  EXPECT_EQ(back->map_id, map.map_id);
  EXPECT_EQ(back->epoch, 4);
  EXPECT_TRUE(back->T_world_left.isApprox(map.T_world_left, 1e-12));
  ASSERT_TRUE(back->T_body_left);
  EXPECT_TRUE(back->T_body_left->isApprox(*map.T_body_left, 1e-9));
  EXPECT_EQ(back->covariance, map.covariance);
  EXPECT_EQ(back->gravity.down_world, map.gravity.down_world);
  EXPECT_EQ(back->gravity.sigma_rad, map.gravity.sigma_rad);
  EXPECT_EQ(back->gravity.source, map.gravity.source);
  EXPECT_FALSE(FromMessage(TerrainHead(map, std::nullopt))->T_body_left) << "no body is known";
}

TEST(TerrainMessagesTest, ListsWhatWasSeenAgainInAsManyMessagesAsItTakes) {
  const TerrainMap map = ExampleMaps(7).First(1);
  std::vector<SeenRegion> seen;
  for (int i = 0; i < 500; ++i) seen.push_back({i + 1, map.t_capture - std::chrono::milliseconds(i)});
  const std::vector<terrain_v1_t> messages = SeenMessages(map, std::nullopt, seen);
  EXPECT_GT(messages.size(), 3u);
  std::map<std::int64_t, Timestamp> back;
  for (const terrain_v1_t& message : messages) {
    EXPECT_LE(message.getEncodedSize(), static_cast<int>(kMaxTerrainMessageBytes));
    EXPECT_EQ(message.kind, terrain_v1_t::SEEN);
    for (const SeenRegion& region : SeenIn(message)) back[region.id] = region.last_seen;
  }
  ASSERT_EQ(back.size(), 500u);
  for (const SeenRegion& region : seen) EXPECT_EQ(back[region.id], region.last_seen);
}

}  // namespace
}  // namespace terrace
