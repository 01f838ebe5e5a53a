// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "datasets/image_file.h"
#include "test/datasets/temporary_folder.h"
#include "tools/camera_config.h"
#include "tools/camera_pairs.h"
#include "tools/frame_file.h"
#include "tools/v4l2_camera.h"

namespace terrace {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr int kWidth = 6, kHeight = 4;  // of one camera
constexpr Timestamp kStart{1'700'000'000'000'000'000};

/// A value of its own for every pixel of both cameras.
std::uint8_t ValueAt(bool right, int u, int v) {
  return static_cast<std::uint8_t>((right ? 128 : 0) + 10 * v + u);
}

void ExpectItsOwnValues(const GrayImage& image, bool right) {
  ASSERT_EQ(image.width, kWidth);
  ASSERT_EQ(image.height, kHeight);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      EXPECT_EQ(image.data[static_cast<std::size_t>(v * kWidth + u)], ValueAt(right, u, v)) << u << " " << v;
}

RawFrame SideBySide(PixelFormat format) {
  RawFrame frame;
  frame.t = kStart;
  frame.format = format;
  frame.width = 2 * kWidth;
  frame.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < 2 * kWidth; ++u) {
      frame.data.push_back(ValueAt(u >= kWidth, u % kWidth, v));
      if (format == PixelFormat::kYuyv) frame.data.push_back(255);  // colour, of no use
    }
  }
  return frame;
}

CameraConfig OneDevice() {
  CameraConfig config;
  config.width = 2 * kWidth;
  config.height = kHeight;
  return config;
}

TEST(CameraPairsTest, SplitsTwoImagesThatLieSideBySide) {
  for (const PixelFormat format : {PixelFormat::kGrey, PixelFormat::kYuyv}) {
    PairMaker maker(OneDevice());
    const auto pair = maker.Add(0, SideBySide(format));
    ASSERT_TRUE(pair);
    ExpectItsOwnValues(pair->left, false);
    ExpectItsOwnValues(pair->right, true);
    EXPECT_EQ(pair->t_capture, kStart);
  }
}

TEST(CameraPairsTest, SplitsTwoImagesThatComeByteByByte) {
  RawFrame frame = SideBySide(PixelFormat::kY8i);
  frame.width = kWidth;
  frame.data.clear();
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      frame.data.push_back(ValueAt(false, u, v));
      frame.data.push_back(ValueAt(true, u, v));
    }
  }
  PairMaker maker(OneDevice());
  const auto pair = maker.Add(0, frame);
  ASSERT_TRUE(pair);
  ExpectItsOwnValues(pair->left, false);
  ExpectItsOwnValues(pair->right, true);
}

TEST(CameraPairsTest, ReadsAJpegImageOfBoth) {
  GrayImage both{64, 16, std::vector<std::uint8_t>(64 * 16, 40)};
  for (int v = 0; v < 16; ++v)
    for (int u = 32; u < 64; ++u) both.data[static_cast<std::size_t>(v * 64 + u)] = 200;
  RawFrame frame;
  frame.format = PixelFormat::kMjpeg;
  frame.width = 64;
  frame.height = 16;
  frame.data = EncodeJpeg(both, 95);
  PairMaker maker(OneDevice());
  const auto pair = maker.Add(0, frame);
  ASSERT_TRUE(pair && pair->problem.empty()) << pair->problem;
  EXPECT_EQ(pair->left.width, 32);
  EXPECT_NEAR(pair->left.data[100], 40, 3);
  EXPECT_NEAR(pair->right.data[100], 200, 3);
}

TEST(CameraPairsTest, ExchangesTheTwoWhereTheRightOneIsSentFirst) {
  CameraConfig config = OneDevice();
  config.swap = true;
  PairMaker maker(config);
  const auto pair = maker.Add(0, SideBySide(PixelFormat::kGrey));
  ASSERT_TRUE(pair);
  ExpectItsOwnValues(pair->left, true);
  ExpectItsOwnValues(pair->right, false);
}

TEST(CameraPairsTest, MakesAProblemOfAFrameThatIsCutOrDamaged) {
  PairMaker maker(OneDevice());
  RawFrame frame = SideBySide(PixelFormat::kYuyv);
  frame.data.resize(frame.data.size() - 1);
  auto pair = maker.Add(0, frame);
  ASSERT_TRUE(pair);
  EXPECT_THAT(pair->problem, HasSubstr("95 bytes, 96 are needed"));
  frame.format = PixelFormat::kMjpeg;
  pair = maker.Add(0, frame);
  ASSERT_TRUE(pair);
  EXPECT_FALSE(pair->problem.empty());
  frame.data.clear();  // as of a buffer that the driver calls damaged
  EXPECT_FALSE(maker.Add(0, frame)->problem.empty());
}

TEST(CameraPairsTest, StampsTheMiddleOfTheExposure) {
  CameraConfig config = OneDevice();
  config.exposure_us = 8000.0;
  config.stamp_offset_ms = -1.0;
  PairMaker maker(config);
  RawFrame frame = SideBySide(PixelFormat::kGrey);
  EXPECT_EQ(maker.Add(0, frame)->t_capture - kStart, milliseconds(3));
  frame.t_is_begin = false;
  EXPECT_EQ(maker.Add(0, frame)->t_capture - kStart, milliseconds(-5));
}

TEST(CameraPairsTest, CountsWhatTheDriverHasLost) {
  PairMaker maker(OneDevice());
  for (const std::uint32_t sequence : {0u, 1u, 4u, 5u, 0u, 1u}) {
    RawFrame frame = SideBySide(PixelFormat::kGrey);
    frame.sequence = sequence;
    maker.Add(0, frame);
  }
  EXPECT_EQ(maker.num_lost(), 2) << "a device that begins anew has lost nothing";
}

RawFrame OneCamera(bool right, Timestamp t) {
  RawFrame frame;
  frame.t = t;
  frame.width = kWidth;
  frame.height = kHeight;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) frame.data.push_back(ValueAt(right, u, v));
  return frame;
}

CameraConfig TwoDevices() {
  CameraConfig config;
  config.device_right = "/dev/video2";
  config.width = kWidth;
  config.height = kHeight;
  config.format = "GREY";
  return config;
}

TEST(CameraPairsTest, PairsTheFramesOfTwoDevicesByTheirStamps) {
  PairMaker maker(TwoDevices());
  EXPECT_FALSE(maker.Add(0, OneCamera(false, kStart)));
  const auto pair = maker.Add(1, OneCamera(true, kStart + milliseconds(2)));
  ASSERT_TRUE(pair);
  ExpectItsOwnValues(pair->left, false);
  ExpectItsOwnValues(pair->right, true);
  EXPECT_EQ(pair->t_capture - kStart, milliseconds(1)) << "between the two";
}

TEST(CameraPairsTest, LeavesOutFramesOfTwoDevicesThatHaveNoPartner) {
  PairMaker maker(TwoDevices());
  int num_pairs = 0;
  // The right camera misses every third frame and begins half a frame later.
  for (int i = 0; i < 30; ++i) {
    num_pairs += maker.Add(0, OneCamera(false, kStart + milliseconds(33 * i))).has_value();
    if (i % 3 != 0) num_pairs += maker.Add(1, OneCamera(true, kStart + milliseconds(33 * i + 1))).has_value();
  }
  EXPECT_EQ(num_pairs, 20);
  EXPECT_GE(maker.num_unmatched(), 9);
  PairMaker apart(TwoDevices());
  for (int i = 0; i < 30; ++i) {
    EXPECT_FALSE(apart.Add(0, OneCamera(false, kStart + milliseconds(33 * i))));
    EXPECT_FALSE(apart.Add(1, OneCamera(true, kStart + milliseconds(33 * i + 16)))) << "never a pair";
  }
}

TEST(CameraConfigTest, ReadsWhatIsShippedAndRefusesWhatCannotBe) {
  for (const auto& entry : std::filesystem::directory_iterator(TERRACE_CAMERAS)) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(ReadCameraConfig(entry.path())) << entry.path();
  }
  const TemporaryFolder folder;
  const auto problem_of = [&](const std::string& text) -> std::string {
    std::ofstream(folder.path() / "camera.yaml") << text;
    try {
      ReadCameraConfig(folder.path() / "camera.yaml");
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(problem_of("{device: /dev/video3, width: 640, height: 240, format: GREY, swap: true}"), "");
  EXPECT_THAT(problem_of("{format: RGB3}"), HasSubstr("format = \"RGB3\" must be"));
  EXPECT_THAT(problem_of("{rate: 30}"), HasSubstr("no such key"));
  EXPECT_THAT(problem_of("{rate_hz: -1}"), HasSubstr("rate_hz = -1 must lie between"));
  EXPECT_THAT(problem_of("{width: 641}"), HasSubstr("must be even"));
  EXPECT_THAT(problem_of("{format: Y8I, device_right: /dev/video2}"), HasSubstr("device_right"));
  EXPECT_THAT(problem_of("{swap: perhaps}"), HasSubstr("true or false"));
}

TEST(FrameFileTest, PlaysWhatItWasGivenAtThePaceAtWhichItCame) {
  const TemporaryFolder folder;
  FrameFileWriter writer(folder.path() / "frames.lcmlog");
  for (int i = 0; i < 5; ++i) {
    for (const bool right : {false, true}) {
      RawFrame frame = OneCamera(right, kStart + milliseconds(20 * i));
      frame.sequence = static_cast<std::uint32_t>(i);
      frame.t_is_begin = right;
      writer.Add(right ? 1 : 0, frame);
    }
  }
  writer.Close();
  const auto start = std::chrono::steady_clock::now();
  RecordedFrames right(folder.path() / "frames.lcmlog", 1, start);
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_FALSE(right.ended());
    std::optional<RawFrame> frame;
    while (!(frame = right.Next(5)) && std::chrono::steady_clock::now() - start < std::chrono::seconds(10)) {
    }
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->t - kStart, milliseconds(20 * i));
    EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(20 * i));
    EXPECT_EQ(frame->sequence, i);
    EXPECT_TRUE(frame->t_is_begin);
    EXPECT_EQ(frame->data, OneCamera(true, kStart).data);
  }
  EXPECT_TRUE(right.ended());
  EXPECT_FALSE(right.Next(0));
}

TEST(V4l2CameraTest, SaysThatADeviceIsNotThereSoThatItCanBeWaitedFor) {
  EXPECT_THROW(V4l2Camera("/dev/video_that_is_missing", OneDevice()), CameraGone);
}

TEST(V4l2CameraTest, RefusesWhatIsNoVideoDevice) {
  EXPECT_THROW(V4l2Camera("/dev/null", OneDevice()), std::runtime_error);
}

TEST(V4l2CameraTest, BringsStampsOfTheMonotonicClockOntoThatOfTheSystem) {
  const Timestamp monotonic{5'000'000'000}, monotonic_now{5'012'000'000};
  EXPECT_EQ(OnSystemClock(monotonic, monotonic_now, kStart), kStart - milliseconds(12));
}

}  // namespace
}  // namespace terrace
