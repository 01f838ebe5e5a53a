// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sys/wait.h>

#include "datasets/image_file.h"
#include "datasets/sequence.h"
#include "test/datasets/temporary_folder.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;

/// Exit code and both streams of the real program.
std::pair<int, std::string> RunConvert(const std::string& arguments) {
  std::string output;
  FILE* pipe = popen((TERRACE_PROGRAM " convert " + arguments + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {-1, ""};
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    output.append(buffer.data(), n);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, output};
}

std::string RigOfSize(int width, int height) {
  const std::string lens =
      "{model: radial-tangential, fx: 50, fy: 50, cx: 31.5, cy: 23.5, distortion: [0, 0, 0, 0]}";
  return "format: terrace-rig\nversion: 1\nimage_size: [" + std::to_string(width) + ", " +
         std::to_string(height) + "]\nleft: " + lens + "\nright: " + lens +
         "\nT_right_left: [1, 0, 0, -0.12, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";
}

/// The left half is darker than the right one, and every frame than the next.
GrayImage BothHalves(int frame) {
  GrayImage both{128, 48, std::vector<std::uint8_t>(128 * 48)};
  for (std::size_t i = 0; i < both.data.size(); ++i)
    both.data[i] =
        static_cast<std::uint8_t>((i % 128 < 64 ? 20 : 120) + 10 * frame + static_cast<int>(i % 7));
  return both;
}

TEST(ConvertTest, SplitsImagesThatHoldBothCameras) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "images");
  for (int i = 0; i < 4; ++i)
    WritePng(folder.path() / "images" / ("00000" + std::to_string(i) + ".png"), BothHalves(i));
  std::ofstream(folder.path() / "images" / "000004.png") << "no image";
  WriteText(folder.path() / "rig.yaml", RigOfSize(64, 48));
  const std::string log = (folder.path() / "run.lcmlog").string();
  const auto [code, said] =
      RunConvert((folder.path() / "images").string() + " " + log +
                 " --side-by-side --rate 20 --calibration " + (folder.path() / "rig.yaml").string());
  ASSERT_EQ(code, 0) << said;
  EXPECT_THAT(said, HasSubstr("5 stereo pairs (1 unreadable)"));
  const auto sequence = OpenSequence(log);
  EXPECT_EQ(sequence->info().calibration.width, 64);
  std::optional<Timestamp> t_before;
  for (int i = 0; i < 4; ++i) {
    const auto frame = sequence->Next();
    ASSERT_TRUE(frame);
    ASSERT_TRUE(frame->pair.problem.empty()) << frame->pair.problem;
    for (std::size_t p = 0; p < 64 * 48; ++p) {
      ASSERT_EQ(frame->pair.left.data[p], BothHalves(i).data[p / 64 * 128 + p % 64]);
      ASSERT_EQ(frame->pair.right.data[p], BothHalves(i).data[p / 64 * 128 + 64 + p % 64]);
    }
    if (t_before) {
      EXPECT_EQ(frame->pair.t_capture - *t_before, std::chrono::milliseconds(50));
    }
    t_before = frame->pair.t_capture;
  }
  EXPECT_FALSE(sequence->Next()->pair.problem.empty()) << "the file that is no image";
}

TEST(ConvertTest, SplitsAVideoThatHoldsBothCamerasByItsOwnTimes) {
  const TemporaryFolder folder;
  const std::string video = (folder.path() / "both.avi").string();
  cv::VideoWriter writer(video, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10.0,
                         {128, 48});
  ASSERT_TRUE(writer.isOpened());
  constexpr int kNumFrames = 6;
  for (int i = 0; i < kNumFrames; ++i) {
    GrayImage both = BothHalves(i);
    cv::Mat3b colours;
    cv::cvtColor(cv::Mat1b(both.height, both.width, both.data.data()), colours, cv::COLOR_GRAY2BGR);
    writer.write(colours);
  }
  writer.release();
  WriteText(folder.path() / "rig.yaml", RigOfSize(64, 48));
  const std::string log = (folder.path() / "run.lcmlog").string();
  const std::string more =
      " --overwrite --side-by-side --calibration " + (folder.path() / "rig.yaml").string();
  for (const auto& [option, interval] : {std::pair{"", std::chrono::milliseconds(100)},
                                         std::pair{" --rate 20", std::chrono::milliseconds(50)}}) {
    const auto [code, said] = RunConvert(video + " " + log + more + option);
    ASSERT_EQ(code, 0) << said;
    EXPECT_THAT(said, HasSubstr("6 stereo pairs (0 unreadable)"));
    const auto sequence = OpenSequence(log);
    std::optional<Timestamp> t_before;
    for (int i = 0; i < kNumFrames; ++i) {
      const auto frame = sequence->Next();
      ASSERT_TRUE(frame && frame->pair.problem.empty());
      // Compressed: on the average it is the same.
      const auto mean = [](const GrayImage& image) {
        return std::accumulate(image.data.begin(), image.data.end(), 0.0) /
               static_cast<double>(image.data.size());
      };
      EXPECT_NEAR(mean(frame->pair.left), 20 + 10 * i + 3, 2.0);
      EXPECT_NEAR(mean(frame->pair.right), 120 + 10 * i + 3, 2.0);
      if (t_before) {
        EXPECT_EQ(frame->pair.t_capture - *t_before, interval);
      }
      t_before = frame->pair.t_capture;
    }
  }
}

TEST(ConvertTest, RefusesToSplitWithoutACalibrationOfThatSizeOrWithoutImages) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "images");
  const std::string images = (folder.path() / "images").string(),
                    log = (folder.path() / "run.lcmlog").string();
  EXPECT_EQ(RunConvert(images + " " + log + " --side-by-side").first, 2);
  WriteText(folder.path() / "rig.yaml", RigOfSize(128, 48));
  const std::string rig = " --side-by-side --calibration " + (folder.path() / "rig.yaml").string();
  EXPECT_THAT(RunConvert(images + " " + log + rig).second, HasSubstr("is no video either"));
  EXPECT_THAT(RunConvert((folder.path() / "rig.yaml").string() + " " + log + rig).second,
              HasSubstr("no video that can be decoded here"));
  WritePng(folder.path() / "images" / "000000.png", BothHalves(0));
  const auto [code, said] = RunConvert(images + " " + log + rig);
  EXPECT_EQ(code, 1);
  EXPECT_THAT(said, HasSubstr("each half is 64x48, the calibration is for 128x48"));
  EXPECT_FALSE(std::filesystem::exists(log));
}

}  // namespace
}  // namespace terrace
