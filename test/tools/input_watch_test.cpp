// SPDX-License-Identifier: BSD-3-Clause
#include "tools/input_watch.h"

#include <algorithm>
#include <random>
#include <string>

#include <gtest/gtest.h>

namespace terrace {
namespace {

using std::chrono::milliseconds;
constexpr Timestamp kWatchStart{1'700'000'000'000'000'000};

const Finding* FindInput(const std::vector<Finding>& findings, const std::string& code) {
  const auto found = std::find_if(findings.begin(), findings.end(),
                                  [&](const Finding& finding) { return finding.code == code; });
  return found == findings.end() ? nullptr : &*found;
}

Severity SeverityOf(const std::vector<Finding>& findings, const std::string& code) {
  const Finding* finding = FindInput(findings, code);
  EXPECT_NE(finding, nullptr) << code;
  return finding == nullptr ? Severity::kGood : finding->severity;
}

/// Two seconds of images 20 times and of an IMU 200 times a second.
struct Feed {
  milliseconds image_age{12};
  milliseconds imu_age{1};
  milliseconds imu_clock{0};  ///< added to the IMU's stamps
  double accel = 9.81;
  double gyro = 0.1;
  bool same_stamps = false;

  InputWatch Watched() const {
    InputWatch watch{LiveConfig()};
    for (int ms = 0; ms < 2000; ms += 5) {
      const Timestamp t = kWatchStart + milliseconds(ms);
      watch.AddImu({t + imu_clock, Eigen::Vector3d(gyro, 0, 0), Eigen::Vector3d(0, 0, accel)}, t + imu_age);
      if (ms % 50 == 0) watch.AddImageStamp(same_stamps ? kWatchStart : t, t + image_age);
    }
    return watch;
  }
};

TEST(InputWatchTest, FindsNothingWrongWithGoodInputs) {
  const InputWatch watch = Feed().Watched();
  for (const auto& findings : {watch.JudgeStamps(), watch.JudgeImu()}) {
    for (const Finding& finding : findings) EXPECT_EQ(finding.severity, Severity::kGood) << InWords(finding);
  }
  EXPECT_NE(FindInput(watch.JudgeStamps(), "images")->text.find("20.0 pairs a second"), std::string::npos);
}

TEST(InputWatchTest, MissesImagesAndTakesAMissingImuForANote) {
  const InputWatch watch{LiveConfig()};
  EXPECT_EQ(SeverityOf(watch.JudgeStamps(), "images"), Severity::kTrouble);
  EXPECT_EQ(SeverityOf(watch.JudgeImu(), "imu"), Severity::kNote);
}

TEST(InputWatchTest, SeesStampsFromTheFutureFromAnotherClockAndThatStandStill) {
  Feed feed;
  feed.image_age = milliseconds(-40);
  EXPECT_EQ(SeverityOf(feed.Watched().JudgeStamps(), "image_stamps"), Severity::kTrouble);
  feed.image_age = milliseconds(100'000'000);
  const auto other_clock = feed.Watched().JudgeStamps();
  EXPECT_EQ(SeverityOf(other_clock, "image_stamps"), Severity::kNote);
  EXPECT_NE(FindInput(other_clock, "image_stamps")->text.find("another clock"), std::string::npos);
  feed = Feed();
  feed.same_stamps = true;
  EXPECT_EQ(SeverityOf(feed.Watched().JudgeStamps(), "image_stamps_order"), Severity::kTrouble);
}

TEST(InputWatchTest, SeesUnitsAndClocksOfTheImu) {
  Feed feed;
  feed.accel = 1.0;  // g
  EXPECT_EQ(SeverityOf(feed.Watched().JudgeImu(), "imu_accel"), Severity::kTrouble);
  feed = Feed();
  feed.gyro = 25.0;  // deg/s
  EXPECT_EQ(SeverityOf(feed.Watched().JudgeImu(), "imu_gyro"), Severity::kTrouble);
  feed = Feed();
  feed.imu_clock = milliseconds(5000);
  EXPECT_EQ(SeverityOf(feed.Watched().JudgeImu(), "imu_clock"), Severity::kTrouble);
}

TEST(InputWatchTest, MeasuresHowLateTheImuIs) {
  Feed feed;
  feed.imu_age = milliseconds(150);  // 138 ms after the image of the same time
  const auto findings = feed.Watched().JudgeImu();
  EXPECT_EQ(SeverityOf(findings, "imu_overlap"), Severity::kTrouble);
  EXPECT_NE(FindInput(findings, "imu_overlap")->text.find("138.0 ms"), std::string::npos)
      << FindInput(findings, "imu_overlap")->text;
  feed.imu_age = milliseconds(60);
  EXPECT_EQ(SeverityOf(feed.Watched().JudgeImu(), "imu_overlap"), Severity::kGood);
}

/// Blocks of random grey, the right image shifted along and across the rows.
StereoPair TexturedPair(int row_shift_px, int base, int contrast) {
  constexpr int kWidth = 320, kHeight = 240, kDisparityPx = 12;
  StereoPair pair;
  for (GrayImage* image : {&pair.left, &pair.right}) {
    const bool is_right = image == &pair.right;
    image->width = kWidth;
    image->height = kHeight;
    image->data.resize(kWidth * kHeight);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const int a = (u + (is_right ? kDisparityPx : 0)) / 6,
                  b = (v + 60 - (is_right ? row_shift_px : 0)) / 6;
        std::minstd_rand random(static_cast<unsigned>(7919 * a + b + 1));
        random.discard(3);
        image->data[static_cast<std::size_t>(v * kWidth + u)] =
            static_cast<std::uint8_t>(base + static_cast<int>(random() % static_cast<unsigned>(contrast)));
      }
    }
  }
  return pair;
}

StereoCalibration Calibration() {
  StereoCalibration calibration;
  calibration.width = 320;
  calibration.height = 240;
  calibration.left.fx = calibration.left.fy = 250.0;
  calibration.left.cx = 159.5;
  calibration.left.cy = 119.5;
  calibration.right = calibration.left;
  calibration.T_rawright_rawleft.translation().x() = -0.1;
  return calibration;
}

std::vector<Finding> JudgePair(StereoPair pair) {
  InputWatch watch{LiveConfig()};
  watch.AddPair(std::move(pair));
  return watch.JudgePairs(Calibration(), {});
}

TEST(InputWatchTest, FindsNothingWrongWithASharpWellLitPairOnItsRows) {
  for (const Finding& finding : JudgePair(TexturedPair(0, 60, 120)))
    EXPECT_EQ(finding.severity, Severity::kGood) << InWords(finding);
}

TEST(InputWatchTest, SeesRowsThatAreOff) {
  const auto findings = JudgePair(TexturedPair(3, 60, 120));
  EXPECT_EQ(SeverityOf(findings, "rows"), Severity::kTrouble);
  EXPECT_NE(FindInput(findings, "rows")->text.find("+3.0"), std::string::npos)
      << FindInput(findings, "rows")->text;
}

TEST(InputWatchTest, SeesDarkAndOverexposedImages) {
  EXPECT_EQ(SeverityOf(JudgePair(TexturedPair(0, 2, 8)), "exposure"), Severity::kTrouble);
  EXPECT_EQ(SeverityOf(JudgePair(TexturedPair(0, 225, 30)), "exposure"), Severity::kTrouble);
}

TEST(InputWatchTest, SeesBlur) {
  StereoPair pair = TexturedPair(0, 60, 120);
  const GrayImage sharp = pair.left;
  constexpr int kRadius = 4;
  for (int v = 0; v < sharp.height; ++v) {
    for (int u = kRadius; u < sharp.width - kRadius; ++u) {
      int sum = 0;
      for (int d = -kRadius; d <= kRadius; ++d)
        sum += sharp.data[static_cast<std::size_t>(v * sharp.width + u + d)];
      pair.left.data[static_cast<std::size_t>(v * sharp.width + u)] =
          static_cast<std::uint8_t>(sum / (2 * kRadius + 1));
    }
  }
  EXPECT_LT(Sharpness(pair.left), Sharpness(sharp));
}

TEST(InputWatchTest, SeesImagesOfAnotherSizeThanTheCalibration) {
  InputWatch watch{LiveConfig()};
  watch.AddPair(TexturedPair(0, 60, 120));
  StereoCalibration calibration = Calibration();
  calibration.width = 640;
  EXPECT_EQ(SeverityOf(watch.JudgePairs(calibration, {}), "image_size"), Severity::kTrouble);
}

}  // namespace
}  // namespace terrace
