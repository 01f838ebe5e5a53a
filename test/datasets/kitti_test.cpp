// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/kitti.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "small_sequences.h"
#include "temporary_folder.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string KittiProblem(const fs::path& path) {
  try {
    OpenKittiSequence(path);
  } catch (const SequenceError& error) {
    return error.what();
  }
  return "";
}

TEST(KittiTest, ReadsGreyCamerasTimesAndALevelBody) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  const auto sequence = OpenKittiSequence(folder.path());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.kind, SequenceKind::kKitti);
  EXPECT_EQ(info.num_frames, 4);
  EXPECT_TRUE(info.has_true_poses);
  EXPECT_FALSE(info.has_imu);
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_TRUE(info.calibration.rectified());
  EXPECT_NEAR(info.calibration.baseline_m(), 0.54, 1e-12);
  EXPECT_EQ(info.calibration.width, kSmallWidth);
  // Ahead is x, the right is -y, down is -z.
  ASSERT_TRUE(info.calibration.T_body_rawleft);
  EXPECT_TRUE(
      (*info.calibration.T_body_rawleft * Eigen::Vector3d(1, 2, 3)).isApprox(Eigen::Vector3d(3, -1, -2)));
  for (int i = 0; i < 4; ++i) {
    const std::optional<SensorFrame> frame = sequence->Next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->pair.t_capture.ns, 100'000'000LL * i + 3'735'900) << i;
    EXPECT_EQ(frame->pair.left.data, SmallImage(2 * i).data);
    EXPECT_EQ(frame->pair.right.data, SmallImage(2 * i + 1).data);
  }
  EXPECT_FALSE(sequence->Next());
}

TEST(KittiTest, FallsBackToTheColourCamerasWithTheirOwnBaselineAndPlace) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path(), 2);
  const KittiCameras cameras = ReadKittiCameras(folder.path());
  EXPECT_EQ(cameras.left, 2);
  EXPECT_EQ(cameras.right, 3);
  // P_i(0, 3) = f t_x + cx t_z.
  EXPECT_NEAR(cameras.calibration.baseline_m(), (1.8 + 14.1 + 15.5 * (0.0049 - 0.0038)) / 30, 1e-9);
  EXPECT_NEAR(cameras.p_cam0_left.x(), -(1.8 - 15.5 * 0.0038) / 30, 1e-9);
  EXPECT_TRUE(cameras.calibration.rectified());
  EXPECT_TRUE(OpenKittiSequence(folder.path())->Next());
}

TEST(KittiTest, ReportsAMissingImageInTheMiddle) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  fs::remove(folder.path() / "image_1" / "000002.png");
  const auto sequence = OpenKittiSequence(folder.path());
  sequence->Next();
  sequence->Next();
  EXPECT_THAT(sequence->Next()->pair.problem, HasSubstr("image_1/000002.png: no such file"));
  EXPECT_EQ(sequence->Next()->pair.problem, "");
}

TEST(KittiTest, EndsWithTheLastImageWhenTimesGoOn) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  WriteText(folder.path() / "times.txt", ReadTextFile(folder.path() / "times.txt") + "5.0\n6.0\n");
  const auto sequence = OpenKittiSequence(folder.path());
  EXPECT_EQ(sequence->info().num_frames, 4);
  EXPECT_THAT(sequence->info().warnings,
              ElementsAre(HasSubstr("times.txt: the last 2 lines left out: there are no images")));
}

TEST(KittiTest, KeepsImagesWithTheirTimesWhenALineIsRubbishOrDoesNotRise) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  WriteText(folder.path() / "times.txt", "0.0\nrubbish\n-1e300\n0.3\n");
  auto sequence = OpenKittiSequence(folder.path());
  EXPECT_EQ(sequence->info().num_frames, 2);
  sequence->Next();
  EXPECT_EQ(sequence->Next()->pair.left.data, SmallImage(6).data);
  WriteText(folder.path() / "times.txt", "0.0\n0.1\n0.05\n0.3\n");
  sequence = OpenKittiSequence(folder.path());
  EXPECT_EQ(sequence->info().num_frames, 3);
  EXPECT_EQ(sequence->num_time_jumps(), 1);
}

TEST(KittiTest, NamesEveryProblemAtOnce) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  fs::remove(folder.path() / "calib.txt");
  fs::remove(folder.path() / "times.txt");
  fs::remove_all(folder.path() / "image_1");
  EXPECT_THAT(KittiProblem(folder.path()),
              AllOf(HasSubstr("calib.txt: no such file"), HasSubstr("times.txt: no such file"),
                    HasSubstr("image_1: no such folder")));
}

TEST(KittiTest, RefusesSenselessCalibrationWithFileAndRule) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  const fs::path calib = folder.path() / "calib.txt";
  const std::string P0 = "P0: 30 0 15.5 0 0 30 11.5 0 0 0 1 0\n";
  WriteText(calib, P0 + "P1: 30 0 15.5 16.2 0 30 11.5 0 0 0 1 0\n");
  EXPECT_THAT(KittiProblem(folder.path()),
              AllOf(HasSubstr("calib.txt"), HasSubstr("are left and right swapped?")));
  WriteText(calib, P0 + "P1: 30 0 15.5 0 0 30 11.5 0 0 0 1 0\n");
  EXPECT_THAT(KittiProblem(folder.path()), HasSubstr("calib.txt: baseline of 0 m"));
  WriteText(calib, P0 + "P1: 0 0 15.5 -16.2 0 0 11.5 0 0 0 1 0\n");
  EXPECT_THAT(KittiProblem(folder.path()), HasSubstr("calib.txt: right camera: fx = 0"));
  WriteText(calib, P0);
  EXPECT_THAT(KittiProblem(folder.path()), HasSubstr("calib.txt: holds no line P1: with 12 numbers"));
  WriteText(calib, "P0: 1 2 3\nP1: nonsense\n");
  EXPECT_THAT(KittiProblem(folder.path()), HasSubstr("calib.txt: no line holds P0: to P3: with 12 numbers"));
}

TEST(KittiTest, SaysWhenTimesEndBeforeTheImages) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  WriteText(folder.path() / "times.txt", "0.0\n0.1\n");
  const auto sequence = OpenKittiSequence(folder.path());
  EXPECT_EQ(sequence->info().num_frames, 2);
  EXPECT_THAT(sequence->info().warnings,
              ElementsAre(HasSubstr("ends before the images do: the last 2 frames left out")));
}

TEST(KittiTest, ReadsImagesNamedByTheirTimesWithOrWithoutAListOfTimes) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  // Not in the order of their names: seconds before the decimal point grow by a digit.
  const char* const kNames[] = {"999999999.900000001.png", "1000000000.000000001.png",
                                "1000000000.100000001.png", "1000000000.200000001.png"};
  for (int side = 0; side < 2; ++side) {
    const fs::path images = folder.path() / ("image_" + std::to_string(side));
    for (int i = 0; i < kSmallFrames; ++i)
      fs::rename(images / ("00000" + std::to_string(i) + ".png"), images / kNames[i]);
  }
  auto sequence = OpenKittiSequence(folder.path());
  EXPECT_EQ(sequence->info().num_frames, 4);
  EXPECT_EQ(sequence->info().t_first.ns, 3'735'900);  // of times.txt
  for (int i = 0; i < kSmallFrames; ++i) {
    const auto frame = sequence->Next();
    EXPECT_EQ(frame->pair.left.data, SmallImage(2 * i).data) << i;
    EXPECT_EQ(frame->pair.right.data, SmallImage(2 * i + 1).data) << i;
  }
  fs::remove(folder.path() / "times.txt");
  sequence = OpenKittiSequence(folder.path());
  EXPECT_EQ(sequence->info().t_first.ns, 999'999'999'900'000'001);
  EXPECT_EQ(sequence->info().t_last.ns, 1'000'000'000'200'000'001);
}

TEST(KittiTest, TakesAnyImageFormatByItsEnding) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  for (int side = 0; side < 2; ++side) {
    const fs::path images = folder.path() / ("image_" + std::to_string(side));
    for (int i = 0; i < kSmallFrames; ++i) {
      fs::remove(images / ("00000" + std::to_string(i) + ".png"));
      const GrayImage image = SmallImage(2 * i + side);
      WriteText(images / ("000000000" + std::to_string(i) + ".pgm"),
                "P5\n32 24\n255\n" + std::string(image.data.begin(), image.data.end()));
    }
  }
  const auto sequence = OpenKittiSequence(folder.path());
  EXPECT_EQ(sequence->Next()->pair.right.data, SmallImage(1).data);
}

TEST(KittiTest, RefusesPairsOfDifferentSize) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path());
  for (int i = 0; i < kSmallFrames; ++i) {
    WritePng(folder.path() / "image_1" / ("00000" + std::to_string(i) + ".png"), SmallImage(i, 20, 24));
  }
  EXPECT_THAT(KittiProblem(folder.path()), HasSubstr("image of 20x24, must be 32x24"));
}

}  // namespace
}  // namespace terrace
