// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/lcm_log.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "datasets/lcm_event_log.h"
#include "datasets/lcm_log_writer.h"
#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/sensor_codec.h"
#include "test/datasets/temporary_folder.h"
#include "test/datasets/tiny_euroc.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

void Convert(const fs::path& sequence_path, const fs::path& log, ImageEncoding encoding,
             int max_frames = 1 << 30) {
  const std::unique_ptr<Sequence> sequence = OpenSequence(sequence_path);
  const SequenceInfo& info = sequence->info();
  const std::vector<TimedPose> truth =
      info.has_true_poses ? TruePosesForLog(LoadTrueTrajectory(sequence_path), info.calibration)
                          : std::vector<TimedPose>();
  LcmLogWriter writer(log, info.calibration, truth, encoding);
  for (int i = 0; i < max_frames; ++i) {
    const std::optional<SensorFrame> frame = sequence->Next();
    if (!frame) break;
    writer.Add(*frame);
  }
  writer.Finish();
}

void ExpectSameCamera(const RawCamera& a, const RawCamera& b) {
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.distortion, b.distortion);
}

void ExpectSamePose(const std::optional<Eigen::Isometry3d>& a, const std::optional<Eigen::Isometry3d>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (a) {
    EXPECT_EQ(a->matrix(), b->matrix());
  }
}

void ExpectSameCalibration(const StereoCalibration& a, const StereoCalibration& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  ExpectSameCamera(a.left, b.left);
  ExpectSameCamera(a.right, b.right);
  ExpectSamePose(a.T_rawright_rawleft, b.T_rawright_rawleft);
  ExpectSamePose(a.T_body_rawleft, b.T_body_rawleft);
  ExpectSamePose(a.T_body_imu, b.T_body_imu);
  EXPECT_EQ(a.imu_noise.gyro_density, b.imu_noise.gyro_density);
  EXPECT_EQ(a.imu_noise.gyro_walk, b.imu_noise.gyro_walk);
  EXPECT_EQ(a.imu_noise.accel_density, b.imu_noise.accel_density);
  EXPECT_EQ(a.imu_noise.accel_walk, b.imu_noise.accel_walk);
}

void ExpectSameFrame(const SensorFrame& a, const SensorFrame& b) {
  EXPECT_EQ(a.frame_id, b.frame_id);
  EXPECT_EQ(a.pair.t_capture, b.pair.t_capture);
  EXPECT_EQ(a.pair.problem, b.pair.problem);
  EXPECT_EQ(a.pair.left.width, b.pair.left.width);
  EXPECT_EQ(a.pair.left.height, b.pair.left.height);
  EXPECT_TRUE(a.pair.left.data == b.pair.left.data);
  EXPECT_TRUE(a.pair.right.data == b.pair.right.data);
  ASSERT_EQ(a.samples.imu.size(), b.samples.imu.size());
  for (std::size_t i = 0; i < a.samples.imu.size(); ++i) {
    EXPECT_EQ(a.samples.imu[i].t, b.samples.imu[i].t);
    EXPECT_EQ(a.samples.imu[i].gyro, b.samples.imu[i].gyro);
    EXPECT_EQ(a.samples.imu[i].accel, b.samples.imu[i].accel);
  }
  ASSERT_EQ(a.samples.priors.size(), b.samples.priors.size());
  for (std::size_t i = 0; i < a.samples.priors.size(); ++i) {
    EXPECT_EQ(a.samples.priors[i].t, b.samples.priors[i].t);
    EXPECT_EQ(a.samples.priors[i].kind, b.samples.priors[i].kind);
    EXPECT_EQ(a.samples.priors[i].T_odom_body.matrix(), b.samples.priors[i].T_odom_body.matrix());
    EXPECT_EQ(a.samples.priors[i].covariance, b.samples.priors[i].covariance);
  }
}

/// Compares up to `max_frames` frames bit by bit.
void ExpectSameSequence(const fs::path& path_a, const fs::path& path_b, int max_frames = 1 << 30) {
  const std::unique_ptr<Sequence> a = OpenSequence(path_a);
  const std::unique_ptr<Sequence> b = OpenSequence(path_b);
  EXPECT_EQ(a->info().has_imu, b->info().has_imu);
  EXPECT_EQ(a->info().has_attitude, b->info().has_attitude);
  EXPECT_EQ(a->info().has_legs, b->info().has_legs);
  EXPECT_EQ(a->info().has_true_poses, b->info().has_true_poses);
  EXPECT_EQ(a->info().t_first, b->info().t_first);
  ExpectSameCalibration(a->info().calibration, b->info().calibration);
  for (int i = 0; i < max_frames; ++i) {
    const std::optional<SensorFrame> frame_a = a->Next();
    const std::optional<SensorFrame> frame_b = b->Next();
    ASSERT_EQ(frame_a.has_value(), frame_b.has_value()) << "frame " << i;
    if (!frame_a) break;
    ExpectSameFrame(*frame_a, *frame_b);
  }
}

class LcmLogTest : public testing::Test {
 protected:
  fs::path Folder(int num_frames = 4, int bad_frame = -1) {
    WriteTinyEuroc(temporary_.path() / "folder", num_frames, bad_frame);
    return temporary_.path() / "folder";
  }
  fs::path Log() const { return temporary_.path() / "a.lcmlog"; }

  TemporaryFolder temporary_;
};

TEST_F(LcmLogTest, ReplaysToTheVeryFramesOfTheFolderItWasMadeFrom) {
  const fs::path folder = Folder(6, 3);
  for (const ImageEncoding encoding : {ImageEncoding::kRaw, ImageEncoding::kLossless}) {
    Convert(folder, Log(), encoding);
    ExpectSameSequence(folder, Log());
  }
  const auto sequence = OpenSequence(Log());
  EXPECT_EQ(sequence->info().num_frames, 6);
  EXPECT_THAT(sequence->info().warnings, IsEmpty());
  for (int i = 0; i < 3; ++i) sequence->Next();
  EXPECT_THAT(sequence->Next()->pair.problem, HasSubstr(".png"))
      << "the frame that could not be read comes as such";
}

TEST_F(LcmLogTest, IsTheSameAfterBeingConvertedAgain) {
  Convert(Folder(), Log(), ImageEncoding::kRaw);
  const fs::path again = temporary_.path() / "b.lcmlog";
  Convert(Log(), again, ImageEncoding::kLossless);
  ExpectSameSequence(Log(), again);
  EXPECT_EQ(LoadTrueTrajectory(Log()).poses.size(), LoadTrueTrajectory(again).poses.size());
}

TEST_F(LcmLogTest, CarriesTheTruePosesOfTheBody) {
  const fs::path folder = Folder();
  Convert(folder, Log(), ImageEncoding::kMjpeg);
  const TrueTrajectory in_folder = LoadTrueTrajectory(folder);
  const TrueTrajectory in_log = LoadTrueTrajectory(Log());
  EXPECT_EQ(in_log.frame, TruthFrame::kBody);
  ASSERT_EQ(in_log.poses.size(), in_folder.poses.size());
  for (std::size_t i = 0; i < in_log.poses.size(); ++i) {
    EXPECT_EQ(in_log.poses[i].t.utime(), in_folder.poses[i].t.utime());
    EXPECT_TRUE(in_log.poses[i].T_world_frame.isApprox(in_folder.poses[i].T_world_frame, 1e-12));
  }
}

TEST_F(LcmLogTest, KeepsItsEventsInOrderOfTimeSoThatThePlayerNeedNotWait) {
  Convert(Folder(), Log(), ImageEncoding::kRaw);
  LcmEventReader reader(Log());
  LcmEvent event;
  std::int64_t last = 0;
  ASSERT_TRUE(reader.Next(&event));
  EXPECT_EQ(event.channel, "TERRACE_CALIBRATION");
  do {
    EXPECT_GE(event.utime, last);
    last = event.utime;
  } while (reader.Next(&event));
}

TEST_F(LcmLogTest, UsesWhatIsCompleteInATruncatedLog) {
  const fs::path folder = Folder();
  Convert(folder, Log(), ImageEncoding::kRaw);
  // The last event but the true poses behind it is the last pair; cut through it.
  LcmEventReader reader(Log());
  LcmEvent event;
  std::int64_t last_pair = 0;
  while (reader.Next(&event)) {
    if (event.channel == "TERRACE_IMAGES") last_pair = event.offset;
  }
  fs::resize_file(Log(), static_cast<std::uintmax_t>(last_pair) + 1000);
  const auto sequence = OpenSequence(Log());
  EXPECT_EQ(sequence->info().num_frames, 3);
  EXPECT_THAT(sequence->info().warnings, ElementsAre(HasSubstr("cut off")));
  ExpectSameSequence(folder, Log(), 3);
}

TEST_F(LcmLogTest, SkipsDamageAndForeignTypes) {
  const fs::path folder = Folder();
  Convert(folder, Log(), ImageEncoding::kRaw);
  std::vector<std::uint8_t> bytes = ReadFileBytes(Log());
  const std::string rubbish = "these bytes are no event \xed\xa1\xda\x01 nor are these";
  LcmEventReader reader(Log());
  LcmEvent event;
  std::int64_t third = 0;
  for (int i = 0; i < 3; ++i) {
    reader.Next(&event);
    third = event.offset;
  }
  bytes.insert(bytes.begin() + third, rubbish.begin(), rubbish.end());
  WriteFileBytes(Log(), bytes);
  {
    // Someone else's message on one of our channels, and one of ours on someone else's.
    std::ofstream(Log(), std::ios::binary | std::ios::app) << [] {
      const TemporaryFolder other;
      LcmEventWriter writer(other.path() / "log");
      const std::vector<std::uint8_t> no_type(20, 7);
      writer.Write(1, "TERRACE_IMU", no_type);
      writer.Write(2, "OTHER", no_type);
      writer.Close();
      return ReadTextFile(other.path() / "log");
    }();
  }
  ExpectSameSequence(folder, Log());
  EXPECT_THAT(OpenSequence(Log())->info().warnings,
              ElementsAre(HasSubstr("1 messages on TERRACE_IMU"),
                          HasSubstr(std::to_string(rubbish.size()) + " bytes")));
}

TEST_F(LcmLogTest, SurvivesAnyDamage) {
  Convert(Folder(), Log(), ImageEncoding::kLossless);
  const std::vector<std::uint8_t> good = ReadFileBytes(Log());
  std::mt19937 random(3);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<std::uint8_t> bad = good;
    for (int i = 0; i < 40; ++i) bad[4 + random() % (bad.size() - 4)] = static_cast<std::uint8_t>(random());
    if (trial % 3 == 0) bad.resize(4 + random() % (bad.size() - 4));
    WriteFileBytes(Log(), bad);
    try {
      const auto sequence = OpenSequence(Log());
      while (sequence->Next()) {
      }
    } catch (const SequenceError&) {
    }
  }
}

TEST_F(LcmLogTest, RefusesALogWithoutStereoInOneSentenceThatListsItsChannels) {
  LcmEventWriter writer(Log());
  const std::vector<std::uint8_t> no_type(20, 7);
  writer.Write(1, "LIDAR", no_type);
  writer.Write(2, "POSE", no_type);
  writer.Write(3, "POSE", no_type);
  writer.Close();
  try {
    OpenSequence(Log());
    FAIL() << "must throw";
  } catch (const SequenceError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("no stereo"), HasSubstr("LIDAR, POSE"), testing::Not(HasSubstr("\n"))));
  }
  EXPECT_EQ(ListLcmLogChannels(Log()).size(), 2u);
}

TEST_F(LcmLogTest, LeavesOutPairsWhoseTimeDoesNotRise) {
  const auto sequence = OpenSequence(Folder());
  LcmLogWriter writer(Log(), sequence->info().calibration, {}, ImageEncoding::kRaw);
  SensorFrame frame = *sequence->Next();
  writer.Add(frame);
  writer.Add(frame);
  frame.pair.t_capture.ns += 1000;
  writer.Add(frame);
  writer.Finish();
  const auto log = OpenSequence(Log());
  EXPECT_EQ(log->info().num_frames, 2);
  EXPECT_EQ(log->num_time_jumps(), 1);
}

TEST(LcmLogOfRecordingsTest, GivesTheFramesOfEveryRecording) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA is not set";
  const TemporaryFolder temporary;
  for (const char* name : {"corridor_stairs", "euroc_mh01", "kitti_00"}) {
    constexpr int kFrames = 3;
    Convert(fs::path(data) / name, temporary.path() / name, ImageEncoding::kLossless, kFrames);
    ExpectSameSequence(fs::path(data) / name, temporary.path() / name, kFrames);
  }
}

TEST(LcmLogOfRecordingsTest, RefusesTheLogsOfOtherRobots) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA is not set";
  int num_logs = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(data) / "lcm")) {
    EXPECT_THROW(OpenSequence(entry.path()), SequenceError) << entry.path();
    ++num_logs;
  }
  EXPECT_GE(num_logs, 3);
}

}  // namespace
}  // namespace terrace
