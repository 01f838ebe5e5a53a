// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/safe_decode.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>
#include <terrace/disparity_v1_t.hpp>
#include <terrace/footstep_plan_v1_t.hpp>
#include <terrace/height_map_v1_t.hpp>
#include <terrace/heightmap_t.hpp>
#include <terrace/localization_lcmt.hpp>
#include <terrace/octree_v1_t.hpp>
#include <terrace/terrain_repair_v1_t.hpp>
#include <terrace/traversability_map_t.hpp>

#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/map_transform_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/region_codec.h"
#include "lcmtypes/request_codec.h"
#include "lcmtypes/sensor_codec.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/terrain_codec.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

template <typename Message>
std::vector<std::uint8_t> Encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())), static_cast<int>(bytes.size()));
  return bytes;
}

/// What a decoded message is used for next must survive it, too.
template <typename Message>
void Use(const Message& message) {
  if constexpr (requires { FromMessage(message); }) static_cast<void>(FromMessage(message));
  if constexpr (std::is_same_v<Message, terrain_v1_t>) {
    static_cast<void>(SeenIn(message));
    for (const region_v1_t& region : message.regions) Use(region);
    for (const staircase_v1_t& staircase : message.staircases) Use(staircase);
  }
}

/// Random bytes, flipped bytes, hostile counts and cut ends: nothing may crash, and what is accepted must be
/// a message that encodes to bytes of the same size. Under the address sanitizer this also finds reads past
/// the end.
template <typename Message>
void Fuzz(const Message& message, unsigned seed, int num_trials = 4000) {
  const std::vector<std::uint8_t> good = Encoded(message);
  ASSERT_TRUE(SafeDecode<Message>(good.data(), good.size()));
  std::mt19937 random(seed);
  for (int trial = 0; trial < num_trials; ++trial) {
    std::vector<std::uint8_t> bad = good;
    for (auto i = random() % 4; i > 0; --i)
      bad[8 + random() % (bad.size() - 8)] = static_cast<std::uint8_t>(random());
    if (trial % 3 == 0 && bad.size() > 12) {
      const std::uint32_t hostile[] = {0, 1, 2, 0x7fffffff, 0xffffffff, 0x80000000, 0x20000000, 0x40000001};
      const std::uint32_t count = hostile[random() % std::size(hostile)];
      const std::size_t at = 8 + random() % (bad.size() - 11);
      for (std::size_t i = 0; i < 4; ++i) bad[at + i] = static_cast<std::uint8_t>(count >> (24 - 8 * i));
    }
    if (trial % 5 == 0) bad.resize(random() % (bad.size() + 1));
    // A buffer of exactly this size, so that the sanitizer sees the first byte behind it.
    const std::vector<std::uint8_t> exact(bad.begin(), bad.end());
    if (const auto decoded = SafeDecode<Message>(exact.data(), exact.size())) {
      EXPECT_EQ(static_cast<std::size_t>(decoded->getEncodedSize()), exact.size());
      Use(*decoded);
    }
  }
}

TEST(SafeDecodeTest, KnowsTheLayoutOfEveryType) {
  // The first four are those of bot_core and fovis, which other robots' programs expect. A changed number
  // means a changed member: mind the walk in safe_decode.cpp.
  EXPECT_EQ(static_cast<std::uint64_t>(pose_t::getHash()), 0x2e16efb052b0105eu);
  EXPECT_EQ(static_cast<std::uint64_t>(image_t::getHash()), 0x14739ffe13d5f5f0u);
  EXPECT_EQ(static_cast<std::uint64_t>(images_t::getHash()), 0x20ba4f05e8f5e33au);
  EXPECT_EQ(static_cast<std::uint64_t>(update_t::getHash()), 0x192f35ef0625f2b7u);
  EXPECT_EQ(static_cast<std::uint64_t>(body_prior_v1_t::getHash()), 0xb7a1accfd3ed5e19u);
  EXPECT_EQ(static_cast<std::uint64_t>(calibration_v1_t::getHash()), 0x4954be38b9e4eb03u);
  EXPECT_EQ(static_cast<std::uint64_t>(command_reply_v1_t::getHash()), 0x6b67609e32507a49u);
  EXPECT_EQ(static_cast<std::uint64_t>(command_v1_t::getHash()), 0x929ae8a758b3dec2u);
  EXPECT_EQ(static_cast<std::uint64_t>(disparity_v1_t::getHash()), 0xf0725489b6041877u);
  EXPECT_EQ(static_cast<std::uint64_t>(terrain_request_v1_t::getHash()), 0x05aecb224ab43ddcu);
  EXPECT_EQ(static_cast<std::uint64_t>(height_map_v1_t::getHash()), 0x9dbaddaa84988219u);
  EXPECT_EQ(static_cast<std::uint64_t>(imu_v1_t::getHash()), 0xf5a2c2bae3b8a624u);
  EXPECT_EQ(static_cast<std::uint64_t>(octree_v1_t::getHash()), 0x617d7e509a7acc9bu);
  EXPECT_EQ(static_cast<std::uint64_t>(pose_v1_t::getHash()), 0x5c824f3ceb87c722u);
  EXPECT_EQ(static_cast<std::uint64_t>(terrain_repair_v1_t::getHash()), 0xdf59e08a291e842cu);
  EXPECT_EQ(static_cast<std::uint64_t>(status_v1_t::getHash()), 0x62d1b74a9cd822beu);
  EXPECT_EQ(static_cast<std::uint64_t>(terrain_v1_t::getHash()), 0xe388adea18aac77bu);
  EXPECT_EQ(static_cast<std::uint64_t>(map_transform_v1_t::getHash()), 0x4151d4882e6d5dbau);
  EXPECT_EQ(static_cast<std::uint64_t>(footstep_plan_v1_t::getHash()), 0x87eccbf934cd246bu);
  // Those of MIT's Cheetah-Software, as its own lcm-gen writes them.
  EXPECT_EQ(static_cast<std::uint64_t>(heightmap_t::getHash()), 0x3b90dc59b5359dcfu);
  EXPECT_EQ(static_cast<std::uint64_t>(traversability_map_t::getHash()), 0x0cb76b76a8383192u);
  EXPECT_EQ(static_cast<std::uint64_t>(localization_lcmt::getHash()), 0x786805dcf8f7ae70u);
}

TEST(SafeDecodeTest, RefusesAnotherType) {
  const std::vector<std::uint8_t> bytes = Encoded(ToMessage(ImuSample()));
  EXPECT_FALSE(SafeDecode<pose_t>(bytes.data(), bytes.size()));
  EXPECT_FALSE(SafeDecode<imu_v1_t>(nullptr, 0));
  EXPECT_FALSE(SafeDecode<imu_v1_t>(bytes.data(), 7));
}

TEST(SafeDecodeTest, RefusesBytesBehindTheMessage) {
  std::vector<std::uint8_t> bytes = Encoded(ToMessage(ImuSample()));
  bytes.push_back(0);
  EXPECT_FALSE(SafeDecode<imu_v1_t>(bytes.data(), bytes.size()));
}

TEST(SafeDecodeTest, SurvivesHostileImages) {
  const GrayImage image{9, 7, std::vector<std::uint8_t>(63, 90)};
  Fuzz(ToMessage(StereoPair{{1600000000066666667}, image, image, ""}, ImageEncoding::kRaw), 1);
  Fuzz(ToMessage(StereoPair{{1600000000066666667}, image, image, ""}, ImageEncoding::kLossless), 2);
  Fuzz(ToMessage(StereoPair{{1600000000066666667}, {}, {}, "no file"}, ImageEncoding::kRaw), 3);
}

TEST(SafeDecodeTest, SurvivesHostileCalibrations) {
  StereoCalibration calibration;
  calibration.name = "a rig";
  calibration.left.distortion = {1, 2, 3, 4};
  calibration.T_body_imu = Eigen::Isometry3d::Identity();
  Fuzz(ToMessage(calibration, {1600000000066666667}), 4);
}

TEST(SafeDecodeTest, SurvivesHostileImuSamplesAndPriors) {
  Fuzz(ToMessage(ImuSample{{1600000000066666667}, {1, 2, 3}, {4, 5, 6}}), 5);
  Fuzz(ToMessage(BodyPrior{{1600000000066666667}, PriorKind::kAttitude, Eigen::Isometry3d::Identity(), {}}),
       6);
  Fuzz(ToMessage(Timestamp{1600000000066666667}, Eigen::Isometry3d::Identity()), 7);
  Fuzz(ToUpdateMessage(PoseEstimate(), std::nullopt), 8);
}

TEST(SafeDecodeTest, SurvivesHostileCommandsAndReplies) {
  command_v1_t command{};
  command.command = command_v1_t::SAVE_MAP;
  command.argument = "map.json";
  Fuzz(command, 9);
  command_reply_v1_t reply{};
  reply.message = "done";
  Fuzz(reply, 10);
}

TEST(SafeDecodeTest, SurvivesHostileTerrainAndStatus) {
  ExampleMaps maps(11);
  const TerrainMap base = maps.First(3);
  Fuzz(SnapshotMessages(base, 20000)[0], 11);
  Fuzz(SnapshotMessages(base, 700)[1], 16);
  Fuzz(DeltaMessages(base, maps.Next(base), 20000)[0], 12);
  const SeenRegion seen[] = {{1, base.t_capture}, {3, base.t_capture}};
  Fuzz(SeenMessages(base, Eigen::Isometry3d::Identity(), seen)[0], 17);
  Status status;
  status.version = "0.1";
  status.stages.resize(3);
  status.stages[1].name = "merging";
  status.inputs.resize(2);
  status.inputs[1].channel = "TERRACE_IMU";
  Fuzz(ToMessage(status), 13);
}

TEST(SafeDecodeTest, SurvivesHostilePosesAndRepairs) {
  PoseEstimate pose;
  pose.t_capture = {1600000000066666667};
  pose.status = TrackingStatus::kTracking;
  pose.reason = "in doubt";
  Fuzz(ToMessage(BodyPoseOf(pose, Eigen::Isometry3d::Identity(), Timestamp{1600000000000000000}, 5)), 18);
  terrain_repair_v1_t repair{};
  repair.n_steps = 2;
  repair.steps.resize(2);
  repair.steps[1].n_missing = 3;
  repair.steps[1].missing = {1, 4, -1};
  Fuzz(repair, 19);
}

TEST(SafeDecodeTest, SurvivesHostileGridsAndTrees) {
  height_map_v1_t grid{};
  grid.frame_id = "world";
  grid.n_layers = 2;
  grid.layer_names = {"elevation", "age"};
  grid.n_values = 4;
  grid.values = {1, 2, 3, 4};
  Fuzz(grid, 14);
  octree_v1_t tree{};
  tree.n_bytes = 3;
  tree.data = {1, 2, 3};
  Fuzz(tree, 15);
  disparity_v1_t disparity{};
  disparity.n_values = 3;
  disparity.values = {1, 0, -2};
  Fuzz(disparity, 20);
}

TEST(SafeDecodeTest, SurvivesHostileTransformsAndPlans) {
  MapTransform transform;
  transform.t = {1600000000066666667};
  transform.file = "hall.terrace";
  transform.placing = MapPlacing::kGiven;
  transform.reason = "somebody said so";
  Fuzz(ToMessage(transform), 22);
  footstep_plan_v1_t plan{};
  plan.frame_id = "world";
  plan.n_steps = 2;
  plan.side = {0, 1};
  plan.pos = plan.normal = {{1, 2, 3}, {4, 5, 6}};
  plan.heading = {0.1, 0.2};
  plan.sigma_height = {0.001f, 0.002f};
  plan.label = plan.gait = {1, 0};
  plan.region_id = {7, 8};
  Fuzz(plan, 23);
  Fuzz(localization_lcmt{}, 24);
}

TEST(SafeDecodeTest, SurvivesHostileRequests) {
  TerrainRequest request{7, RequestKind::kOctree, 2.0, std::chrono::seconds(9), true, {}, 0.1};
  request.box = {Eigen::Vector3d(-1, -2, -3), Eigen::Vector3d(1, 2, 3)};
  Fuzz(ToMessage(request), 21);
}

}  // namespace
}  // namespace terrace
