// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(ChannelConfigTest, HasNoProblemsByDefault) { EXPECT_THAT(ChannelConfig().Problems(), IsEmpty()); }

TEST(ChannelConfigTest, RefusesNamesThatLcmCannotCarryAndNamesUsedTwice) {
  ChannelConfig config;
  config.images = std::string(64, 'A');
  config.imu = "IMU.*";
  config.status = config.terrain;
  config.reply = "";
  config.body_pose_kind = "wheels";
  EXPECT_THAT(config.Problems(),
              ElementsAre(HasSubstr("images"), HasSubstr("imu"), HasSubstr("reply"),
                          HasSubstr("must not be the channel of terrain"), HasSubstr("body_pose_kind")));
}

}  // namespace
}  // namespace terrace
