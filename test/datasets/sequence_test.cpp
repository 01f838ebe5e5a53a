// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/sequence.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/ground_truth.h"
#include "small_sequences.h"
#include "temporary_folder.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::IsEmpty;

std::string ProblemOf(const fs::path& path) {
  try {
    OpenSequence(path);
  } catch (const SequenceError& error) {
    return error.what();
  }
  return "";
}

TEST(SequenceTest, RecognisesFoldersByWhatTheyHold) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path() / "a");
  WriteSmallKitti(folder.path() / "b");
  WriteSmallKitti(folder.path() / "c", 2);
  EXPECT_EQ(OpenSequence(folder.path() / "a")->info().kind, SequenceKind::kEuroc);
  EXPECT_EQ(OpenSequence(folder.path() / "b")->info().kind, SequenceKind::kKitti);
  EXPECT_EQ(OpenSequence(folder.path() / "c")->info().kind, SequenceKind::kKitti);
  EXPECT_EQ(OpenSequence(folder.path() / "a" / "")->info().num_frames, 4);
}

TEST(SequenceTest, SaysInOneSentenceWhatASequenceIs) {
  const TemporaryFolder folder;
  EXPECT_THAT(ProblemOf(folder.path() / "none"), HasSubstr("none: no such file or folder"));
  EXPECT_THAT(ProblemOf(folder.path()), HasSubstr("not a sequence; must be an EuRoC ASL folder (holds mav0/)"));
  WriteText(folder.path() / "note.txt", "hello");
  EXPECT_THAT(ProblemOf(folder.path() / "note.txt"), HasSubstr("not a sequence"));
  EXPECT_THAT(ProblemOf("/dev/zero"), HasSubstr("not a sequence"));
  EXPECT_THAT(ProblemOf(""), HasSubstr("no such file or folder"));
}

TEST(SequenceTest, NamesAFolderThatCannotBeLookedInto) {
  const TemporaryFolder folder;
  WriteSmallEuroc(folder.path());
  fs::remove_all(folder.path() / "mav0" / "imu0");
  fs::create_symlink("imu0", folder.path() / "mav0" / "imu0");
  EXPECT_THAT(ProblemOf(folder.path()), HasSubstr("mav0/imu0: Too many levels of symbolic links"));
}

/// What is known of a recording without reading it.
struct Recording {
  const char* name;
  SequenceKind kind;
  std::int64_t num_frames;
  double baseline_m;
  bool rectified;
  TruthFrame truth;
};
void PrintTo(const Recording& recording, std::ostream* out) { *out << recording.name; }

class RecordingTest : public testing::TestWithParam<Recording> {};

TEST_P(RecordingTest, IsReadFromEndToEnd) {
  const char* data = std::getenv("TERRACE_DATA");
  if (data == nullptr) GTEST_SKIP() << "TERRACE_DATA does not name the folder with the recordings";
  const fs::path path = fs::path(data) / GetParam().name;
  const auto sequence = OpenSequence(path);
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.kind, GetParam().kind);
  EXPECT_EQ(info.num_frames, GetParam().num_frames);
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_NEAR(info.calibration.baseline_m(), GetParam().baseline_m, 1e-4);
  EXPECT_EQ(info.calibration.rectified(), GetParam().rectified);
  Timestamp t_last{-1};
  std::int64_t num_frames = 0;
  // Decoding all of them takes seconds; the first ten show that images are read.
  while (num_frames < 10) {
    const std::optional<SensorFrame> frame = sequence->Next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->pair.problem, "");
    EXPECT_GT(frame->pair.t_capture, t_last);
    t_last = frame->pair.t_capture;
    EXPECT_EQ(frame->frame_id, num_frames++);
  }
  const TrueTrajectory truth = LoadTrueTrajectory(path);
  EXPECT_EQ(truth.frame, GetParam().truth);
  EXPECT_LE(truth.poses.front().t, info.t_first);
  EXPECT_GE(truth.poses.back().t, info.t_last);
}

INSTANTIATE_TEST_SUITE_P(
    Recordings, RecordingTest,
    testing::Values(Recording{"corridor_stairs", SequenceKind::kEuroc, 288, 0.12, true, TruthFrame::kRawLeft},
                    Recording{"euroc_mh01", SequenceKind::kEuroc, 160, 0.11007, false, TruthFrame::kRawLeft},
                    Recording{"kitti_00", SequenceKind::kKitti, 60, 0.53717, true,
                              TruthFrame::kRectifiedLeft}),
    [](const auto& recording) { return std::string(recording.param.name); });

}  // namespace
}  // namespace terrace
