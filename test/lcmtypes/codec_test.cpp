// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/codec.h"

#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  ASSERT_EQ(back->stages.size(), 2u);
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

TEST(CodecTest, MeasuresTheSlopeAgainstGravityNotAgainstZ) {
  TerrainRegion region;
  region.id = 1;
  Gravity gravity;
  gravity.down_world = Eigen::Vector3d(0.1, 0.0, -1.0).normalized();
  EXPECT_NEAR(ToMessage(region, gravity).slope, std::atan(0.1), 1e-6);
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
  EXPECT_EQ(back->region_ids, stairs.region_ids);
  EXPECT_EQ(back->last_seen, stairs.last_seen);
}

TEST(CodecTest, RefusesValuesThatCannotBeMeant) {
  ExampleMaps maps(3);
  const region_v1_t good = ToMessage(*maps.Region(1, 1), Gravity());
  ASSERT_TRUE(FromMessage(good));
  region_v1_t bad = good;
  bad.label = 8;
  EXPECT_FALSE(FromMessage(bad)) << "no such label";
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
  const std::vector<terrain_v1_t> parts = SnapshotMessages(map, 10000);
  EXPECT_GT(parts.size(), 5u);
  std::set<std::int64_t> ids;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    EXPECT_LE(parts[i].getEncodedSize(), 10000);
    EXPECT_EQ(parts[i].kind, terrain_v1_t::SNAPSHOT);
    EXPECT_EQ(parts[i].part, static_cast<int>(i));
    EXPECT_EQ(parts[i].n_parts, static_cast<int>(parts.size()));
    EXPECT_EQ(parts[i].seq, map.seq);
    EXPECT_EQ(parts[i].n_staircases, i == 0 ? 1 : 0);
    for (const region_v1_t& region : parts[i].regions) EXPECT_TRUE(ids.insert(region.id).second);
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
  map.regions[1] = maps.Region(2, 2);
  map.regions.erase(map.regions.begin() + 3);
  const std::vector<terrain_v1_t> parts = DeltaMessages(base, map);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].kind, terrain_v1_t::DELTA);
  EXPECT_EQ(parts[0].base_seq, base.seq);
  EXPECT_EQ(parts[0].seq, map.seq);
  EXPECT_THAT(parts[0].removed_ids, ElementsAre(4));
  ASSERT_EQ(parts[0].n_regions, 1);
  EXPECT_EQ(parts[0].regions[0].id, 2);
  EXPECT_EQ(parts[0].n_staircases, 1);
}

}  // namespace
}  // namespace terrace
