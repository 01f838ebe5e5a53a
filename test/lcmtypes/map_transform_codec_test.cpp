// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/map_transform_codec.h"

#include <limits>

#include <gtest/gtest.h>

namespace terrace {
namespace {

MapTransform Example() {
  MapTransform transform;
  transform.t = {1600000000066666667};
  transform.map_id = 12;
  transform.file = "hall.terrace";
  transform.placing = MapPlacing::kGiven;
  transform.reason = "somebody said so";
  transform.T_map_world.translation() = Eigen::Vector3d(1, 2, 3);
  transform.T_map_world.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (int i = 0; i < 36; ++i) transform.covariance(i / 6, i % 6) = 0.25 * i;
  return transform;
}

TEST(MapTransformCodecTest, KeepsEveryMember) {
  const MapTransform before = Example();
  const auto after = FromMessage(ToMessage(before));
  ASSERT_TRUE(after);
  EXPECT_EQ(after->t, before.t);
  EXPECT_EQ(after->map_id, before.map_id);
  EXPECT_EQ(after->file, before.file);
  EXPECT_EQ(after->placing, before.placing);
  EXPECT_EQ(after->reason, before.reason);
  EXPECT_TRUE(after->T_map_world.isApprox(before.T_map_world, 1e-12));
  EXPECT_EQ(after->covariance, before.covariance);
}

TEST(MapTransformCodecTest, SendsNoTransformWhereNoneIsKnown) {
  MapTransform transform = Example();
  transform.placing = MapPlacing::kNotFound;
  const map_transform_v1_t message = ToMessage(transform);
  for (const double value : message.quat) EXPECT_EQ(value, 0.0);
  const auto after = FromMessage(message);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->placing, MapPlacing::kNotFound);
}

TEST(MapTransformCodecTest, RefusesWhatCannotBeMeant) {
  map_transform_v1_t message = ToMessage(Example());
  message.placing = 4;
  EXPECT_FALSE(FromMessage(message));
  message = ToMessage(Example());
  message.cov[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(FromMessage(message));
  message = ToMessage(Example());
  message.placing = map_transform_v1_t::NOT_FOUND;  // but with a transform
  EXPECT_FALSE(FromMessage(message));
}

}  // namespace
}  // namespace terrace
