// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_surroundings.h"

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "lcmtypes/request_codec.h"
#include "mapping/octomap_bytes.h"
#include "test/client/made_terrain.h"

namespace terrace {
namespace {

constexpr std::size_t kBeforeContent = 20;  // of a record
constexpr double kLeafSize_m = 0.02;

template <typename Value>
std::vector<Value> ValuesOf(const ViewBytes& record, std::size_t from) {
  std::vector<Value> values((record->size() - kBeforeContent - from) / sizeof(Value));
  std::memcpy(values.data(), record->data() + kBeforeContent + from, values.size() * sizeof(Value));
  return values;
}

/// A floor of 2 x 2 m at z = 0 about the origin, with a hole of 0.4 m in its middle.
TerrainQuery QueryToFloor() {
  return TerrainQuery(MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(-1, -1, 1, 1),
                                          {Rectangle(-0.2, -0.2, 0.2, 0.2)})}));
}

TEST(ViewSurroundingsTest, SendsTheCellsThatNoRegionPassesThrough) {
  // On the floor, in the hole, in the air; the last one four leaves wide.
  octree_v1_t message{};
  message.encoding = octree_v1_t::OCTOMAP_OT;
  message.data = OctomapBytes({{{25, 25, 0}, 0, 3}, {{2, -3, 0}, 0, 3}, {{8, 4, 40}, 2, 3}}, kLeafSize_m,
                              OctomapFormat::kOt);
  message.n_bytes = static_cast<std::int32_t>(message.data.size());
  const TerrainQuery query = QueryToFloor();
  const ViewBytes record = CellsRecord(message, {}, &query);
  ASSERT_TRUE(record);
  const auto cells = ValuesOf<std::uint16_t>(record, 16);
  EXPECT_EQ(cells, (std::vector<std::uint16_t>{0, 0, 0, 1, 6, 7, 40, 4}));
  float head[4];
  std::memcpy(head, record->data() + kBeforeContent, sizeof(head));
  EXPECT_FLOAT_EQ(head[0], 0.02F);
  EXPECT_FLOAT_EQ(head[1], 0.04F);
  EXPECT_FLOAT_EQ(head[2], -0.06F);
  EXPECT_FLOAT_EQ(head[3], 0.0F);
  EXPECT_EQ(ValuesOf<std::uint16_t>(CellsRecord(message, {}, nullptr), 16).size(), 12u);
  message.data.pop_back();
  EXPECT_FALSE(CellsRecord(message, {}, &query));
}

/// A camera 1 m over the floor that looks straight down, and sees it level; from u = 32 on, something 0.5 m
/// high.
disparity_v1_t LookingDown() {
  StereoCamera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 60.0;
  camera.cx = 31.5;
  camera.cy = 23.5;
  camera.baseline_m = 0.1;
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  T_world_left.translation() << 0.3, 0.0, 1.0;
  T_world_left.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  disparity_v1_t message = DisparityHead(camera, Timestamp{5'000'000'000}, T_world_left);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const float known = u < 32 ? 6.0F : 12.0F;
      message.values.push_back(DisparityNumber(v == 0 ? std::numeric_limits<float>::quiet_NaN() : known));
    }
  }
  message.n_values = static_cast<std::int32_t>(message.values.size());
  return message;
}

TEST(ViewSurroundingsTest, SendsThePointsOfADisparityImageThatAreNoPlaneOfTheMap) {
  TerrainQuery query(MadeMap({MadeRegion(1, TerrainLabel::kWalkway, LevelAt(0.0), Rectangle(-3, -3, 3, 3))}));
  const ViewBytes record = PointsRecord(LookingDown(), {}, &query);
  ASSERT_TRUE(record);
  const auto offsets = ValuesOf<std::int16_t>(record, 16);
  ASSERT_EQ(offsets.size(), 3u * 8u * 11u);  // half of each row of 16, without the first row of 12
  float head[4];
  std::memcpy(head, record->data() + kBeforeContent, sizeof(head));
  for (std::size_t i = 0; i < offsets.size(); i += 3) {
    EXPECT_NEAR(head[2] + head[3] * offsets[i + 2], 0.5, 0.002);
    EXPECT_GT(head[0] + head[3] * offsets[i], 0.3);
  }
}

TEST(ViewSurroundingsTest, SendsNoPointsWhereThePoseIsNotKnownOrTheMessageIsDamaged) {
  disparity_v1_t lost = LookingDown();
  lost.pose_known = 0;
  EXPECT_FALSE(PointsRecord(lost, {}, nullptr));
  disparity_v1_t cut = LookingDown();
  cut.values.pop_back();
  EXPECT_FALSE(PointsRecord(cut, {}, nullptr));
  EXPECT_FALSE(DisparityRecord(cut, {}));
  disparity_v1_t senseless = LookingDown();
  senseless.cx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(PointsRecord(senseless, {}, nullptr));
}

TEST(ViewSurroundingsTest, ShowsDisparityInColoursAndWhatIsNotKnownInBlack) {
  const ViewBytes record = DisparityRecord(LookingDown(), {});
  ASSERT_TRUE(record);
  float range[2];
  std::memcpy(range, record->data() + kBeforeContent, sizeof(range));
  EXPECT_FLOAT_EQ(range[0], 6.0F);
  EXPECT_FLOAT_EQ(range[1], 12.0F);
  const auto jpeg = ValuesOf<std::uint8_t>(record, 8);
  const cv::Mat3b picture = cv::imdecode(jpeg, cv::IMREAD_COLOR);
  ASSERT_EQ(picture.size(), cv::Size(64, 48));
  const cv::Vec3b far = picture(30, 5), near = picture(30, 60);  // blue, green, red
  EXPECT_GT(far[0], far[1] + 30);
  EXPECT_GT(near[1], near[0] + 100);
  EXPECT_LT(cv::norm(picture(0, 5)), 60.0);
}

}  // namespace
}  // namespace terrace
