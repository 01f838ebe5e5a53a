// SPDX-License-Identifier: BSD-3-Clause
#include "tools/health.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace terrace {
namespace {

Status WellStatus() {
  Status status;
  status.state = DaemonState::kRunning;
  status.tracking = TrackingStatus::kTracking;
  status.gravity_source = GravitySource::kImu;
  status.fps_in = status.fps_out = 30.0;
  status.dense_ratio = 0.7;
  status.map_id = status.map_seq = 5;
  status.inputs = {{"images", "TERRACE_IMAGES", 300, 0, 30.0, 12.0},
                   {"imu", "TERRACE_IMU", 2000, 0, 200.0, 3.0}};
  return status;
}

const Finding* Find(const std::vector<Finding>& findings, const std::string& code) {
  const auto found = std::find_if(findings.begin(), findings.end(),
                                  [&](const Finding& finding) { return finding.code == code; });
  return found == findings.end() ? nullptr : &*found;
}

TEST(HealthTest, FindsNothingAboutADaemonThatIsWell) {
  EXPECT_TRUE(JudgeStatus(WellStatus(), nullptr).empty());
}

TEST(HealthTest, TakesEveryStateButRunningForTrouble) {
  for (const DaemonState state :
       {DaemonState::kStarting, DaemonState::kDegraded, DaemonState::kPaused, DaemonState::kNoInput,
        DaemonState::kNoCalibration, DaemonState::kStopping}) {
    Status status = WellStatus();
    status.state = state;
    EXPECT_TRUE(AnyTrouble(JudgeStatus(status, nullptr))) << Name(state);
  }
}

TEST(HealthTest, NamesTheReasonAsACodeAndSaysWhatToDo) {
  Status status = WellStatus();
  status.state = DaemonState::kNoInput;
  status.reason = "no images on TERRACE_IMAGES";
  status.reason_code = ReasonCode::kNoImages;
  const std::vector<Finding> findings = JudgeStatus(status, nullptr);
  const Finding* finding = Find(findings, "no_images");
  ASSERT_NE(finding, nullptr);
  EXPECT_NE(finding->text.find("no images on TERRACE_IMAGES"), std::string::npos);
  EXPECT_NE(finding->remedy.find("terrace camera"), std::string::npos);
}

TEST(HealthTest, TakesACountThatGrowsForTroubleAndAnOldOneForANote) {
  Status before = WellStatus();
  before.num_imu_gaps = 3;
  const std::vector<Finding> old = JudgeStatus(before, nullptr);
  ASSERT_NE(Find(old, "imu_gaps"), nullptr);
  EXPECT_EQ(Find(old, "imu_gaps")->severity, Severity::kNote);
  EXPECT_FALSE(AnyTrouble(old));
  EXPECT_TRUE(JudgeStatus(before, &before).empty()) << "nothing has happened since";
  Status after = before;
  after.num_imu_gaps = 4;
  const std::vector<Finding> grown = JudgeStatus(after, &before);
  ASSERT_NE(Find(grown, "imu_gaps"), nullptr);
  EXPECT_EQ(Find(grown, "imu_gaps")->severity, Severity::kTrouble);
  EXPECT_EQ(Find(grown, "imu_gaps")->text, "1 gaps in the IMU's samples");
}

TEST(HealthTest, MissesAnImuThatHasGoneSilentButNoneThatNeverSpoke) {
  Status status = WellStatus();
  status.inputs[1].age_ms.reset();
  EXPECT_TRUE(JudgeStatus(status, nullptr).empty());
  status.inputs[1].age_ms = 3200.0;
  const std::vector<Finding> findings = JudgeStatus(status, nullptr);
  ASSERT_NE(Find(findings, "imu_silent"), nullptr);
  EXPECT_NE(Find(findings, "imu_silent")->text.find("3.2 s"), std::string::npos);
}

TEST(HealthTest, PutsTroublesBeforeNotes) {
  Status status = WellStatus();
  status.dense_ratio = 0.05;
  status.vertical_disparity_px = 1.5;
  const std::vector<Finding> findings = JudgeStatus(status, nullptr);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].code, "rows_off");
  EXPECT_EQ(findings[1].code, "few_pixels");
}

TEST(HealthTest, WritesJsonThatHoldsStateFindingsInputsAndStages) {
  Status status = WellStatus();
  status.tracking = TrackingStatus::kLost;
  status.reason = "dark \xff";  // no UTF-8
  status.stages = {{"odometry", 30, 30, 2, 1, 4.0, 4.5, 9.0, 12.0}};
  const auto json = nlohmann::json::parse(StatusJson(status, JudgeStatus(status, nullptr)));
  EXPECT_FALSE(json["healthy"].get<bool>());
  EXPECT_EQ(json["findings"][0]["code"], "not_tracking");
  EXPECT_EQ(json["inputs"][1]["name"], "imu");
  EXPECT_EQ(json["inputs"][1]["rate_hz"], 200.0);
  EXPECT_EQ(json["stages"][0]["n_dropped"], 2);
  const std::string page = StatusPage(status, JudgeStatus(status, nullptr));
  EXPECT_NE(page.find("not healthy"), std::string::npos);
  EXPECT_NE(page.find("TERRACE_IMU"), std::string::npos);
}

}  // namespace
}  // namespace terrace
