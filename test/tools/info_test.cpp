// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "datasets/image_file.h"
#include "datasets/lcm_event_log.h"
#include "test/datasets/small_sequences.h"
#include "test/datasets/temporary_folder.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::HasSubstr;

struct Outcome {
  int exit_code = -1;
  std::string output;  ///< both streams
};

/// Runs the real program: exit codes are part of what it promises.
Outcome Terrace(const std::string& arguments) {
  Outcome run;
  FILE* pipe = popen((TERRACE_PROGRAM " " + arguments + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    run.output.append(buffer.data(), n);
  const int status = pclose(pipe);
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return run;
}

TEST(ToolboxTest, SaysHowItIsUsed) {
  EXPECT_EQ(Terrace("--help").exit_code, 0);
  EXPECT_THAT(Terrace("--help").output, HasSubstr("info"));
  EXPECT_EQ(Terrace("--version").exit_code, 0);
  EXPECT_THAT(Terrace("--version").output, HasSubstr("terrace "));
  EXPECT_EQ(Terrace("").exit_code, 2);
  EXPECT_EQ(Terrace("dance").exit_code, 2);
  EXPECT_EQ(Terrace("info").exit_code, 2);
  EXPECT_EQ(Terrace("info --loud x").exit_code, 2);
}

TEST(InfoTest, DescribesAnEurocFolder) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path());
  const Outcome run = Terrace("info " + folder.path().string());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(
      run.output,
      AllOf(HasSubstr("EuRoC ASL folder"), HasSubstr("4 frames over 0.30 s, 10.0 per second"),
            HasSubstr("32x24"), HasSubstr("baseline 0.1000 m, already rectified"),
            HasSubstr("IMU, body attitude, leg odometry"), HasSubstr("21 poses of the body, 0.40 m long")));
}

TEST(InfoTest, DescribesAKittiFolder) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  const Outcome run = Terrace("info " + folder.path().string());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, AllOf(HasSubstr("KITTI odometry folder"), HasSubstr("beside the images: nothing"),
                                HasSubstr("4 poses of the rectified left camera, 2.40 m long")));
}

TEST(InfoTest, ListsTheChannelsOfAForeignLog) {
  const TemporaryFolder folder;
  const fs::path log = folder.path() / "robot.lcmlog";
  LcmEventWriter writer(log);
  // The fingerprint of bot_core.pose_t, whose layout our pose_t has, and one of somebody else's.
  std::vector<std::uint8_t> pose = {0x2e, 0x16, 0xef, 0xb0, 0x52, 0xb0, 0x10, 0x5e};
  pose.resize(8 + 18 * 8);
  for (int i = 0; i < 11; ++i) writer.Write(1'000'000 + 100'000 * i, "POSE", pose);
  const std::vector<std::uint8_t> foreign = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  writer.Write(1'500'000, "LIDAR", foreign);
  writer.Close();
  const Outcome run = Terrace("info " + log.string());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, AllOf(HasSubstr("LCM log that cannot be replayed"),
                                testing::ContainsRegex("POSE +2e16efb052b0105e +pose_t +11 +10\\.0"),
                                testing::ContainsRegex("LIDAR +0102030405060708 +not ours +1 ")));
}

TEST(InfoTest, DescribesAResultAndItsMap) {
  const TemporaryFolder folder;
  WriteText(folder.path() / "terrain_map.json",
            R"({"format": "terrace-map", "version": 1, "t_capture_ns": 5, "frame": "world", "regions": [
            {"id": 1, "revision": 1, "label": "walkway", "confidence": 0.9, "normal": [0,0,1], "offset_m": 0,
             "rms_m": 0.003, "area_m2": 2.0, "outline": [[0,0,0],[2,0,0],[2,1,0],[0,1,0]], "holes": [],
             "staircase": null, "step_index": null, "first_seen_ns": 0, "last_seen_ns": 5}], "staircases": []})");
  WriteText(folder.path() / "trajectory.tum", "0.000000000 0 0 0 0 0 0 1\n1.000000000 0.5 0 0 0 0 0 1\n");
  for (const std::string& path : {folder.path().string(), (folder.path() / "terrain_map.json").string()}) {
    const Outcome run = Terrace("info " + path);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    EXPECT_THAT(run.output, AllOf(HasSubstr("map: 1 region, 0 staircases"),
                                  testing::ContainsRegex("walkway +1 of +2\\.00 m2")));
  }
  EXPECT_THAT(Terrace("info " + folder.path().string()).output,
              HasSubstr("trajectory: 2 poses, 0.50 m long"));
}

TEST(InfoTest, DescribesImages) {
  const TemporaryFolder folder;
  WritePng(folder.path() / "photo.png", GrayImage{2, 2, {0, 7, 9, 200}});
  WritePng(folder.path() / "disparity.png", Gray16Image{2, 1, {0, 2560}});
  WriteText(folder.path() / "d.pfm",
            std::string("Pf\n2 1\n-1\n") + std::string("\0\0\x80\x3f\0\0\x80\x7f", 8));
  EXPECT_THAT(Terrace("info " + (folder.path() / "photo.png").string()).output,
              HasSubstr("PNG image of 2x2, 8 bits grey, values 0 to 200, 25.0 % zero"));
  EXPECT_THAT(Terrace("info " + (folder.path() / "disparity.png").string()).output,
              AllOf(HasSubstr("16 bits grey, values 0 to 2560, 50.0 % zero"), HasSubstr("up to 10.00 px")));
  EXPECT_THAT(Terrace("info " + (folder.path() / "d.pfm").string()).output,
              HasSubstr("PFM image of 2x1, 50.0 % known, values 1 to 1"));
}

TEST(InfoTest, SaysInOneSentenceWhatItCannotRead) {
  const TemporaryFolder folder;
  WriteText(folder.path() / "note.txt", "hello");
  WriteText(folder.path() / "map.json", "{");
  WriteText(folder.path() / "photo.png", "\x89PNG\r\n\x1a\n");
  fs::create_directories(folder.path() / "empty");
  fs::create_directories(folder.path() / "euroc" / "mav0");
  for (const char* name : {"none", "note.txt", "map.json", "photo.png", "empty", "euroc"}) {
    const Outcome run = Terrace("info " + (folder.path() / name).string());
    EXPECT_EQ(run.exit_code, 1) << name;
    EXPECT_THAT(run.output, AllOf(HasSubstr("terrace: "), HasSubstr(name)));
  }
}

}  // namespace
}  // namespace terrace
