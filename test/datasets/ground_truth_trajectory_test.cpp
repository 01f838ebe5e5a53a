// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/ground_truth.h"
#include "small_sequences.h"
#include "temporary_folder.h"

namespace terrace {
namespace {

TEST(GroundTruthTrajectoryTest, ReadsTheBodyStatesOfAnEurocFolder) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path());
  const TrueTrajectory truth = LoadTrueTrajectory(folder.path());
  EXPECT_EQ(truth.frame, TruthFrame::kBody);
  ASSERT_EQ(truth.poses.size(), 21u);
  const TimedPose& pose = truth.poses[2];
  EXPECT_EQ(pose.t.ns, SmallTime(0) - 10'000'000);
  // Turned left by 90 deg: ahead is y.
  EXPECT_TRUE((pose.T_world_frame * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(0.04, 1, 0.4), 1e-6));
}

TEST(GroundTruthTrajectoryTest, PrefersCameraPosesAtTheTimesOfTheFrames) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path());
  WriteText(folder.path() / "groundtruth_tum.txt", "1.0 0 0 0 0 0 0 1\n");
  EXPECT_EQ(LoadTrueTrajectory(folder.path()).frame, TruthFrame::kRawLeft);
}

TEST(GroundTruthTrajectoryTest, ReadsCameraPosesToTheNanosecond) {
  const TemporaryFolder folder;
  WriteText(folder.path() / "groundtruth_tum.txt",
            "# timestamp tx ty tz qx qy qz qw\n1403636584.763555584 1 2 3 0 0 0.70710678 0.70710678\n"
            "1403636584.8 1 2 3 0 0 0 1\n1403636583 9 9 9 0 0 0 1\n1403636585 1 2 3 0 0 0 0.5\n");
  EXPECT_TRUE(HasTrueTrajectory(folder.path()));
  const TrueTrajectory truth = LoadTrueTrajectory(folder.path());
  EXPECT_EQ(truth.frame, TruthFrame::kRawLeft);
  ASSERT_EQ(truth.poses.size(), 2u);  // one does not rise, one is no rotation
  EXPECT_EQ(truth.poses[0].t.ns, 1403636584763555584);
  EXPECT_EQ(truth.poses[1].t.ns, 1403636584800000000);
  EXPECT_TRUE(
      (truth.poses[0].T_world_frame * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(1, 3, 3), 1e-6));
}

TEST(GroundTruthTrajectoryTest, MovesKittiPosesIntoTheLeftCameraThatIsUsed) {
  const TemporaryFolder folder;
  WriteSmallKitti(folder.path(), 2);
  const TrueTrajectory truth = LoadTrueTrajectory(folder.path());
  EXPECT_EQ(truth.frame, TruthFrame::kRectifiedLeft);
  ASSERT_EQ(truth.poses.size(), 4u);
  EXPECT_EQ(truth.poses[3].t.ns, 303'735'900);
  EXPECT_NEAR(truth.poses[3].T_world_frame.translation().x(), -(1.8 - 15.5 * 0.0038) / 30, 1e-9);
  EXPECT_NEAR(truth.poses[3].T_world_frame.translation().z(), 2.4 - 0.0038, 1e-9);
}

TEST(GroundTruthTrajectoryTest, TakesTheCamerasOwnTrackingWhereNothingBetterIsThere) {
  const TemporaryFolder folder;
  WriteText(folder.path() / "zed_tracking.tum", "0.050073 1 2 3 0 0 0.70710678 0.70710678\n");
  EXPECT_TRUE(HasTrueTrajectory(folder.path()));
  const TrueTrajectory truth = LoadTrueTrajectory(folder.path());
  EXPECT_EQ(truth.frame, TruthFrame::kRectifiedLeft);
  ASSERT_EQ(truth.poses.size(), 1u);
  EXPECT_EQ(truth.poses[0].t.ns, 50'073'000);
  WriteText(folder.path() / "groundtruth_tum.txt", "1.0 0 0 0 0 0 0 1\n");
  EXPECT_EQ(LoadTrueTrajectory(folder.path()).frame, TruthFrame::kRawLeft);
}

TEST(GroundTruthTrajectoryTest, SaysWhatIsMissingOrUnreadable) {
  const TemporaryFolder folder;
  EXPECT_FALSE(HasTrueTrajectory(folder.path()));
  EXPECT_THROW(LoadTrueTrajectory(folder.path()), FileError);
  WriteText(folder.path() / "groundtruth_tum.txt", "nothing\n");
  EXPECT_THROW(LoadTrueTrajectory(folder.path()), FileError);
  WriteText(folder.path() / "groundtruth_tum.txt",
            "99999999999999999999.0 1 2 3 0 0 0 1\n-1.0 1 2 3 0 0 0 1\n");
  EXPECT_THROW(LoadTrueTrajectory(folder.path()), FileError);
}

TEST(GroundTruthTrajectoryTest, SaysHowTimesThatAreNoSecondsMayBeMeant) {
  const TemporaryFolder folder;
  const auto problem_of = [&](const std::string& line) -> std::string {
    WriteText(folder.path() / "groundtruth_tum.txt", line);
    try {
      LoadTrueTrajectory(folder.path());
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(problem_of("1.6e+09 1 2 3 0 0 0 1\n").find("1.6e+09 is a rounded time"), std::string::npos);
  EXPECT_NE(problem_of("1600000000066666 1 2 3 0 0 0 1\n")
                .find("with the factor 1e-06 1600000000066666 would be one"),
            std::string::npos);
  EXPECT_NE(problem_of("1600000000066666667 1 2 3 0 0 0 1\n").find("with the factor 1e-09"),
            std::string::npos);
}

}  // namespace
}  // namespace terrace
