// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/input_troubles.h"

#include <gtest/gtest.h>

namespace terrace {
namespace {

TEST(InputTroublesTest, NamesWhatHasGoneWrongSinceTheLastCallAndNothingElse) {
  InputTroubles troubles;
  Status status;
  EXPECT_EQ(troubles.Take(status, 0), "");
  status.num_imu_gaps = 3;
  EXPECT_EQ(
      troubles.Take(status, 2),
      "since the last status: 3 gaps in the samples of the IMU, or samples that came too late, 2 frames that "
      "came while the odometry was behind");
  EXPECT_EQ(troubles.Take(status, 2), "") << "that was said";
  status.num_bad_frames = 1;
  status.num_decode_errors = 5;
  status.num_time_jumps = 7;
  EXPECT_EQ(troubles.Take(status, 2),
            "since the last status: 1 unreadable pairs of images, 5 messages that are not taken, 7 images "
            "whose time "
            "does not rise");
}

}  // namespace
}  // namespace terrace
