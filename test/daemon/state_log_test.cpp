// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/state_log.h"

#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace terrace {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Status InState(DaemonState state, TrackingStatus tracking, ReasonCode code = ReasonCode::kNone,
               std::string reason = "") {
  Status status;
  status.state = state;
  status.tracking = tracking;
  status.reason_code = code;
  status.reason = std::move(reason);
  return status;
}

TEST(StateLogTest, SaysEachStateOnceWithTheReasonAndWhatToDo) {
  StateLog log;
  const Status well = InState(DaemonState::kRunning, TrackingStatus::kTracking);
  const auto first = log.Add(well);
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->is_trouble);
  EXPECT_FALSE(log.Add(well)) << "nothing has changed";
  const Status dark =
      InState(DaemonState::kDegraded, TrackingStatus::kBridging, ReasonCode::kFewFeatures, "only 3 features");
  const auto trouble = log.Add(dark);
  ASSERT_TRUE(trouble);
  EXPECT_TRUE(trouble->is_trouble);
  EXPECT_THAT(trouble->text, HasSubstr("degraded, bridging: only 3 features; light"));
  Status darker = dark;
  darker.reason = "only 2 features";
  EXPECT_FALSE(log.Add(darker)) << "the same reason in other numbers";
  const auto again = log.Add(well);
  ASSERT_TRUE(again);
  EXPECT_FALSE(again->is_trouble);
  EXPECT_THAT(again->text, HasSubstr("running, tracking"));
}

TEST(StateLogTest, SaysThatTrackingWasLostBetweenTwoStatuses) {
  StateLog log;
  Status status = InState(DaemonState::kRunning, TrackingStatus::kTracking);
  log.Add(status);
  status.num_lost = 4;
  const auto lost = log.Add(status);
  ASSERT_TRUE(lost);
  EXPECT_THAT(lost->text, HasSubstr("lost for 4 frames"));
  EXPECT_FALSE(log.Add(status));
}

TEST(StateLogTest, DoesNotRepeatItselfWhileTrackingIsLost) {
  StateLog log;
  Status status =
      InState(DaemonState::kDegraded, TrackingStatus::kLost, ReasonCode::kNotFoundAgain, "nothing is known");
  status.num_lost = 10;
  ASSERT_TRUE(log.Add(status));
  status.num_lost = 25;
  EXPECT_FALSE(log.Add(status));
  status.tracking = TrackingStatus::kTracking;
  status.epoch = 1;
  const auto found = log.Add(status);
  ASSERT_TRUE(found);
  EXPECT_THAT(found->text, HasSubstr("another world begins (epoch 1)"));
  EXPECT_THAT(found->text, Not(HasSubstr("lost for")));
}

TEST(StateLogTest, HasARemedyForWhateverHasAReasonOfItsOwn) {
  for (int code = 2; code < kNumReasonCodes; ++code)
    EXPECT_FALSE(RemedyFor(static_cast<ReasonCode>(code)).empty()) << Name(static_cast<ReasonCode>(code));
}

}  // namespace
}  // namespace terrace
