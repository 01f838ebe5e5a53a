// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/fault.h"

#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "core/print.h"
#include "datasets/sequence.h"
#include "test/datasets/temporary_folder.h"
#include "test/datasets/tiny_euroc.h"

namespace terrace::synthetic {
namespace {

namespace fs = std::filesystem;

constexpr int kNumTinyFrames = 12;

std::string EveryByteOf(const fs::path& folder) {
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.insert(entry.path());
  std::string text;
  for (const fs::path& file : files)
    text += fs::relative(file, folder).string() + "\n" + ReadTextFile(file) + "\n";
  return text;
}

class FaultTest : public testing::Test {
 protected:
  void SetUp() override { WriteTinyEuroc(Source(), kNumTinyFrames, -1); }

  fs::path Source() const { return folder_.path() / "source"; }
  fs::path Damaged(const std::string& fault) const {
    FaultyRecording recording = ReadRecording(Source());
    if (!fault.empty()) ApplyFault(fault, recording);
    const fs::path out = folder_.path() / ("out" + fault);
    fs::create_directories(out);
    WriteRecording(recording, out);
    return out;
  }

  TemporaryFolder folder_;
};

TEST_F(FaultTest, ThereAreSixtyOfThemAndEachHasANameOfItsOwn) {
  std::set<std::string> names;
  for (const Fault& fault : AllFaults()) names.insert(fault.name);
  EXPECT_EQ(names.size(), AllFaults().size());
  EXPECT_GE(names.size(), 60u);
}

TEST_F(FaultTest, ACopyWithoutAFaultPlaysLikeItsSource) {
  const auto source = OpenSequence(Source()), copy = OpenSequence(Damaged(""));
  for (int i = 0; i < kNumTinyFrames; ++i) {
    const auto a = source->Next(), b = copy->Next();
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->pair.t_capture, b->pair.t_capture);
    EXPECT_EQ(a->pair.left.data, b->pair.left.data);
    EXPECT_EQ(a->pair.right.data, b->pair.right.data);
    EXPECT_EQ(a->samples.imu.size(), b->samples.imu.size());
    EXPECT_EQ(a->samples.priors.size(), b->samples.priors.size());
  }
}

TEST_F(FaultTest, EveryFaultChangesSomethingAndAlwaysTheSame) {
  const std::string undamaged = EveryByteOf(Damaged(""));
  for (const Fault& fault : AllFaults()) {
    // The IMU of this recording is at rest in free fall.
    const std::string what = fault.name == "imu_clipped" ? "imu_clipped:0.5" : fault.name;
    const std::string once = EveryByteOf(Damaged(what));
    EXPECT_TRUE(once != undamaged) << what;
    EXPECT_TRUE(once == EveryByteOf(Damaged(what))) << what;
  }
}

TEST_F(FaultTest, TheStrengthCounts) {
  EXPECT_NE(EveryByteOf(Damaged("rows_off:2")), EveryByteOf(Damaged("rows_off:3")));
}

TEST_F(FaultTest, TheTruthOfARepeatedTimeStampIsThatOfTheFirstImageWithIt) {
  FaultyRecording recording = ReadRecording(Source());
  std::string truth;
  for (std::size_t i = 0; i < recording.left.size(); ++i)
    truth += Printed("%.9f %zu 0 0 0 0 0 1\n", 1e-9 * static_cast<double>(recording.left[i].t.ns), i);
  std::ofstream(Source() / "groundtruth_tum.txt") << truth;
  recording.left[5].t = recording.left[4].t;
  const fs::path out = folder_.path() / "out";
  fs::create_directories(out);
  WriteRecording(recording, out);
  const std::string written = ReadTextFile(out / "groundtruth_tum.txt");
  EXPECT_NE(written.find(" 4 0 0 0"), std::string::npos) << written;
  EXPECT_EQ(written.find(" 5 0 0 0"), std::string::npos) << written;
  EXPECT_NE(written.find(" 6 0 0 0"), std::string::npos) << written;
}

TEST_F(FaultTest, RefusesWhatCannotHappen) {
  EXPECT_THROW(Damaged("nonsense"), FaultError);
  EXPECT_THROW(Damaged("rows_off:much"), FaultError);
  fs::remove_all(Source() / "mav0" / "legs0");
  EXPECT_THROW(Damaged("legs_jump"), FaultError);
}

}  // namespace
}  // namespace terrace::synthetic
