// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/request_codec.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "lcmtypes/codec_values.h"
#include "test/lcmtypes/over_memq.h"

namespace terrace {
namespace {

TerrainRequest SomeRequest() {
  TerrainRequest request;
  request.id = 77;
  request.kind = RequestKind::kOctree;
  request.rate_hz = 2.5;
  request.duration = std::chrono::milliseconds(12500);
  request.around_robot = true;
  request.box = {Eigen::Vector3d(-1.1, -2.2, -0.3), Eigen::Vector3d(3.4, 2.2, 0.7)};
  request.resolution_m = 0.125;
  return request;
}

TEST(RequestCodecTest, CarriesRequests) {
  const TerrainRequest sent = SomeRequest();
  const auto message = OverMemq(ToMessage(sent));
  ASSERT_TRUE(message);
  const auto request = FromMessage(*message);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->id, sent.id);
  EXPECT_EQ(request->kind, sent.kind);
  EXPECT_EQ(request->rate_hz, sent.rate_hz);
  EXPECT_EQ(request->duration, sent.duration);
  EXPECT_EQ(request->around_robot, sent.around_robot);
  EXPECT_EQ(request->box.min(), sent.box.min());
  EXPECT_EQ(request->box.max(), sent.box.max());
  EXPECT_EQ(request->resolution_m, sent.resolution_m);
}

TEST(RequestCodecTest, RefusesValuesThatCannotBeMeant) {
  const auto refused = [](auto change) {
    terrain_request_v1_t message = ToMessage(SomeRequest());
    change(&message);
    return !FromMessage(message);
  };
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(refused([](auto*) {}));
  EXPECT_TRUE(refused([](auto* m) { m->what = 0; }));
  EXPECT_TRUE(refused([](auto* m) { m->what = 5; }));
  EXPECT_TRUE(refused([](auto* m) { m->rate = -1.0F; }));
  EXPECT_TRUE(refused([](auto* m) { m->rate = kNaN; }));
  EXPECT_TRUE(refused([](auto* m) { m->duration_s = 1e20F; }));
  EXPECT_TRUE(refused([](auto* m) { m->duration_s = -1.0F; }));
  EXPECT_TRUE(refused([](auto* m) { m->resolution = kNaN; }));
  EXPECT_TRUE(refused([](auto* m) { m->box_min[1] = kNaN; }));
  EXPECT_TRUE(refused([](auto* m) { m->box_max[2] = m->box_min[2] - 0.1; }));
}

TEST(RequestCodecTest, ADisparityIsKeptToA64thOfAPixelAndWhatDoesNotFitIsUnknown) {
  for (const float disparity_px : {0.02F, 1.0F, 37.26F, 511.0F})
    EXPECT_NEAR(DisparityFromNumber(DisparityNumber(disparity_px)), disparity_px, 0.5F / 64.0F);
  for (const float disparity_px :
       {0.0F, -3.0F, 0.001F, 512.0F, 1e30F, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_TRUE(std::isnan(DisparityFromNumber(DisparityNumber(disparity_px)))) << disparity_px;
}

TEST(RequestCodecTest, ADisparityImageNamesItsCameraAndItsPoseWhereThatIsKnown) {
  const StereoCamera camera{4, 2, 100.0, 101.0, 1.5, 0.5, 0.12};
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  T_world_left.translation() = Eigen::Vector3d(1, 2, 3);
  const disparity_v1_t known = DisparityHead(camera, {1600000000066666667}, T_world_left);
  EXPECT_EQ(known.t_capture_ns, 1600000000066666667);
  EXPECT_EQ(known.utime, 1600000000066666);
  EXPECT_EQ(known.fx, 100.0);
  EXPECT_EQ(known.fy, 101.0);
  EXPECT_EQ(known.baseline_m, 0.12);
  EXPECT_TRUE(known.pose_known);
  EXPECT_TRUE(ReadPose(known.pos, known.quat)->isApprox(T_world_left));
  EXPECT_FALSE(DisparityHead(camera, {0}, std::nullopt).pose_known);
}

}  // namespace
}  // namespace terrace
