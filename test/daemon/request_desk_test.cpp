// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/request_desk.h"

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/terrain_follower.h"
#include "lcmtypes/request_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"
#include "test/client/made_terrain.h"
#include "test/mapping/plane_world.h"

namespace terrace {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::int64_t kMapId = 9;

/// A floor at 0.2 m over x 0..2, y 0..1, with a step onto 0.35 m behind it.
TerrainMapPtr FloorAndStep() {
  auto map = MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.2), Rectangle(0, 0, 2, 1)),
                      MadeRegion(2, TerrainLabel::kStairTread, LevelAt(0.35), Rectangle(2, 0, 2.3, 1))});
  map->seq = 5;
  return map;
}

class RequestDeskTest : public testing::Test {
 protected:
  RequestDeskTest() {
    const ChannelConfig channels;
    Subscribe<&RequestDeskTest::OnReply>(&lcm_, channels.reply, this);
    Subscribe<&RequestDeskTest::OnHeights>(&lcm_, channels.height_map, this)->setQueueCapacity(1000);
    Subscribe<&RequestDeskTest::OnOctree>(&lcm_, channels.octree, this);
    Subscribe<&RequestDeskTest::OnDisparity>(&lcm_, channels.disparity, this);
    Subscribe<&RequestDeskTest::OnMapBox>(&lcm_, channels.map_box, this);
    sources_.map = FloorAndStep();
    sources_.map_id = kMapId;
    sources_.camera = &camera_;
    request_.id = 3;
    request_.box = {Eigen::Vector3d(0.5, 0.25, -1), Eigen::Vector3d(2.5, 0.75, 1)};
    request_.resolution_m = 0.1;
  }

  /// What the reply says.
  std::pair<int, std::string> Ask(const TerrainRequest& request) {
    desk_.Take(ToMessage(request), now_);
    HandleAll();
    EXPECT_EQ(reply_.request_id, request.id);
    return {reply_.result, reply_.message};
  }
  void Frame(milliseconds later = milliseconds(33)) {
    now_ += later;
    desk_.Answer(sources_, now_);
    HandleAll();
  }
  void HandleAll() {
    while (lcm_.handleTimeout(0) > 0) {
    }
  }

  static constexpr int kOk = command_reply_v1_t::OK;
  static constexpr int kRefused = command_reply_v1_t::REFUSED;

  lcm::LCM lcm_{"memq://"};
  RequestDesk desk_{&lcm_, ChannelConfig()};
  RequestDesk::Time now_{seconds(100)};
  StereoCamera camera_{4, 3, 100.0, 100.0, 1.5, 1.0, 0.1};
  AnswerSources sources_;
  TerrainRequest request_;
  command_reply_v1_t reply_;
  std::vector<height_map_v1_t> heights_;
  std::vector<octree_v1_t> octrees_;
  std::vector<disparity_v1_t> disparities_;
  TerrainFollower map_box_;

 private:
  void OnReply(const lcm::ReceiveBuffer* buffer, const std::string&) {
    reply_ = *SafeDecode<command_reply_v1_t>(buffer->data, buffer->data_size);
  }
  void OnHeights(const lcm::ReceiveBuffer* buffer, const std::string&) {
    heights_.push_back(*SafeDecode<height_map_v1_t>(buffer->data, buffer->data_size));
  }
  void OnOctree(const lcm::ReceiveBuffer* buffer, const std::string&) {
    octrees_.push_back(*SafeDecode<octree_v1_t>(buffer->data, buffer->data_size));
  }
  void OnDisparity(const lcm::ReceiveBuffer* buffer, const std::string&) {
    disparities_.push_back(*SafeDecode<disparity_v1_t>(buffer->data, buffer->data_size));
  }
  void OnMapBox(const lcm::ReceiveBuffer* buffer, const std::string&) {
    map_box_.Receive(buffer->data, buffer->data_size);
  }
};

TEST_F(RequestDeskTest, AHeightMapHasTheHeightsOfTheGroundAndSaysWhereItKnowsNone) {
  EXPECT_EQ(Ask(request_).first, kOk);
  Frame();
  Frame();
  ASSERT_EQ(heights_.size(), 1u);
  const height_map_v1_t& grid = heights_[0];
  EXPECT_EQ(grid.map_id, kMapId);
  EXPECT_EQ(grid.seq, 5);
  ASSERT_EQ(grid.nx, 20);
  ASSERT_EQ(grid.ny, 5);
  ASSERT_EQ(grid.layer_names, (std::vector<std::string>{"elevation", "variance", "label", "age"}));
  EXPECT_NEAR(grid.center[0], 1.5, 1e-9);
  EXPECT_NEAR(grid.center[1], 0.5, 1e-9);
  const std::size_t num = 100;
  ASSERT_EQ(grid.values.size(), 4 * num);
  for (std::size_t i = 0; i < 20; ++i) {
    for (std::size_t j = 0; j < 5; ++j) {
      const double x = grid.center[0] + (static_cast<double>(i) - 9.5) * 0.1;
      const std::size_t at = i * 5 + j;
      if (x > 2.3) {
        for (std::size_t layer = 0; layer < 4; ++layer)
          EXPECT_TRUE(std::isnan(grid.values[layer * num + at]));
        continue;
      }
      EXPECT_FLOAT_EQ(grid.values[at], x < 2.0 ? 0.2F : 0.35F);
      EXPECT_GT(grid.values[num + at], 0.0F);
      EXPECT_FLOAT_EQ(grid.values[2 * num + at], x < 2.0 ? 1.0F : 3.0F);
      EXPECT_FLOAT_EQ(grid.values[3 * num + at], 2.0F);
    }
  }
}

TEST_F(RequestDeskTest, ABoxAroundTheRobotGoesWithItAndWaitsWhereItIsNotKnown) {
  request_.around_robot = true;
  request_.box = {Eigen::Vector3d(-0.5, -0.5, -2), Eigen::Vector3d(0.5, 0.5, 2)};
  EXPECT_EQ(Ask(request_).first, kOk);
  Frame();
  EXPECT_TRUE(heights_.empty());
  sources_.T_world_left = Eigen::Isometry3d::Identity();
  sources_.T_world_left->translation() = Eigen::Vector3d(1.5, 0.75, 0.5);
  Frame();
  ASSERT_EQ(heights_.size(), 1u);
  EXPECT_NEAR(heights_[0].center[0], 1.5, 1e-9);
  EXPECT_NEAR(heights_[0].center[1], 0.75, 1e-9);
}

TEST_F(RequestDeskTest, AnOctreeHoldsTheLeavesInTheBox) {
  PlaneWorld world;
  world.AddFloor(-1, 4, -2, 2, 0.1);
  TerrainOctree octree(MappingConfig{});
  std::mt19937 random(1);
  for (int i = 0; i < 6; ++i) {
    const PoseEstimate pose = LookFrom(i, 0.02 * i, 0, 0.55, 0, 0.5);
    octree.Insert(world.See(TestCamera(), pose.T_world_left, i, 2, 0.1, &random), TestCamera(), pose);
  }
  request_.kind = RequestKind::kOctree;
  request_.box = {Eigen::Vector3d(0.6, -0.2, -1), Eigen::Vector3d(1.2, 0.2, 1)};
  EXPECT_EQ(Ask(request_).first, kOk);
  Frame();
  EXPECT_TRUE(octrees_.empty()) << "answered without an octree";
  sources_.octree = &octree;
  Frame();
  ASSERT_EQ(octrees_.size(), 1u);
  EXPECT_EQ(octrees_[0].encoding, octree_v1_t::OCTOMAP_OT);
  EXPECT_FLOAT_EQ(octrees_[0].resolution, 0.02F);
  EXPECT_EQ(octrees_[0].map_id, kMapId);
  EXPECT_EQ(octrees_[0].data, OctomapBytes(octree.LeavesIn(request_.box), 0.02, OctomapFormat::kOt));
  EXPECT_GT(octrees_[0].data.size(), 1000u);
}

TEST_F(RequestDeskTest, ADisparityImageIsThatOfTheFrame) {
  auto image = std::make_shared<DisparityImage>();
  image->t_capture = {1600000000066666667};
  image->disparity_px = cv::Mat1f(3, 4, std::numeric_limits<float>::quiet_NaN());
  image->disparity_px(1, 2) = 12.25F;
  sources_.disparity = image;
  request_.kind = RequestKind::kDisparity;
  EXPECT_EQ(Ask(request_).first, kOk);
  Frame();
  ASSERT_EQ(disparities_.size(), 1u);
  EXPECT_EQ(disparities_[0].t_capture_ns, 1600000000066666667);
  ASSERT_EQ(disparities_[0].values.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(disparities_[0].values[i], i == 6 ? 784 : 0);
  EXPECT_FALSE(disparities_[0].pose_known);
}

TEST_F(RequestDeskTest, ABoxOfTheMapIsAMapOfTheRegionsThatReachIntoIt) {
  request_.kind = RequestKind::kMap;
  request_.box = {Eigen::Vector3d(2.1, 0, 0), Eigen::Vector3d(3, 1, 1)};
  EXPECT_EQ(Ask(request_).first, kOk);
  Frame();
  ASSERT_TRUE(map_box_.map());
  ASSERT_EQ(map_box_.map()->regions.size(), 1u);
  EXPECT_EQ(map_box_.map()->regions[0]->id, 2);
  EXPECT_EQ(map_box_.map()->map_id, kMapId);
}

TEST_F(RequestDeskTest, AnswersComeAtTheRateForTheDurationAndNoLonger) {
  request_.rate_hz = 5.0;
  request_.duration = seconds(2);
  EXPECT_EQ(Ask(request_).first, kOk);
  for (int i = 0; i < 100; ++i) Frame(milliseconds(40));
  EXPECT_NEAR(static_cast<double>(heights_.size()), 10.0, 1.0);
}

TEST_F(RequestDeskTest, ALaterRequestTakesThePlaceOfTheOneWithTheSameId) {
  request_.rate_hz = 5.0;
  request_.duration = seconds(50);
  Ask(request_);
  request_.rate_hz = 0.0;
  Ask(request_);
  for (int i = 0; i < 100; ++i) Frame(milliseconds(40));
  EXPECT_EQ(heights_.size(), 1u);
}

TEST_F(RequestDeskTest, WhatCostsTooMuchIsRefusedWithTheRule) {
  const auto refusal = [&](auto change) {
    TerrainRequest request = request_;
    change(&request);
    const auto [result, sentence] = Ask(request);
    return result == kRefused ? sentence : "taken";
  };
  EXPECT_EQ(refusal([](TerrainRequest* r) { r->rate_hz = 10.5; }),
            "rate = 10.5 must be 0 or lie between 0.1 and 10 Hz");
  EXPECT_EQ(refusal([](TerrainRequest* r) { r->rate_hz = 1e-6; }),
            "rate = 1e-06 must be 0 or lie between 0.1 and 10 Hz");
  const auto standing = [](TerrainRequest* r, int duration_s) {
    r->rate_hz = 1.0;
    r->duration = seconds(duration_s);
  };
  EXPECT_EQ(refusal([&](TerrainRequest* r) { standing(r, 0); }),
            "duration_s = 0 must lie above 0 and at 60 at most: ask again before it ends");
  EXPECT_EQ(refusal([&](TerrainRequest* r) { standing(r, 61); }),
            "duration_s = 61 must lie above 0 and at 60 at most: ask again before it ends");
  EXPECT_EQ(refusal([](TerrainRequest* r) { r->resolution_m = 0.0; }),
            "resolution = 0 must be at least 0.001 m");
  EXPECT_EQ(refusal([](TerrainRequest* r) { r->resolution_m = 0.0015; }).substr(0, 15), "1334 x 334 cell");
  const auto far = [](TerrainRequest* r) { r->box.max().x() = 1e30; };
  EXPECT_EQ(refusal(far), "the box reaches farther than 100000 m");
  const auto large = [](TerrainRequest* r) {
    r->kind = RequestKind::kOctree;
    r->box.max().y() = 30.25;
  };
  EXPECT_EQ(refusal(large), "an edge of the box has 30 m, must have at most 16");
  EXPECT_EQ(refusal([](TerrainRequest* r) { r->box.max().z() = -2.0; }).substr(0, 15), "a value cannot ");
  Frame();
  EXPECT_TRUE(heights_.empty());
}

TEST_F(RequestDeskTest, NoMoreThanEightAreAnsweredAtOnceAndEachHasItsTurn) {
  request_.rate_hz = 10.0;
  request_.duration = seconds(4);
  std::set<float> resolutions;
  for (int id = 1; id <= 8; ++id) {
    request_.id = id;
    request_.resolution_m = 0.1 * id;
    resolutions.insert(static_cast<float>(request_.resolution_m));
    EXPECT_EQ(Ask(request_).first, kOk);
  }
  request_.id = 99;
  EXPECT_EQ(Ask(request_), (std::pair<int, std::string>(kRefused, "8 requests are being answered already")));
  for (int i = 0; i < 60; ++i) Frame();
  EXPECT_LE(heights_.size(), 60u) << "one answer a frame";
  for (const float resolution : resolutions)
    EXPECT_GE(std::count_if(heights_.begin(), heights_.end(),
                            [&](const height_map_v1_t& grid) { return grid.resolution == resolution; }),
              6);
  now_ += seconds(5);
  EXPECT_EQ(Ask(request_).first, kOk) << "those before have ended";
}

TEST_F(RequestDeskTest, AllAnswersTogetherKeepWithinTheBytesASecond) {
  request_.rate_hz = 10.0;
  request_.duration = seconds(20);
  request_.box = {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(3.16, 3.16, 1)};
  request_.resolution_m = 0.01;
  for (request_.id = 1; request_.id <= 4; ++request_.id) EXPECT_EQ(Ask(request_).first, kOk);
  for (int i = 0; i < 300; ++i) Frame();
  double bytes = 0.0;
  for (const height_map_v1_t& grid : heights_) bytes += static_cast<double>(grid.getEncodedSize());
  const double largest = static_cast<double>(heights_.at(0).getEncodedSize());
  const double allowed = RequestDesk::kMaxBytesPerSecond * (300 * 0.033 + 1.0) + largest;
  EXPECT_LE(bytes, allowed);
  EXPECT_GE(bytes, 0.8 * allowed);
}

}  // namespace
}  // namespace terrace
