// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate_all.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "evaluation/baseline.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

TEST(EvaluateAllTest, ReadsALineOfAList) {
  const EvaluationJob job =
      ParseJob("stairs scene:stairs_up,frames=60 --set odometry.use_imu=false", "a.list:1");
  EXPECT_EQ(job.name, "stairs");
  EXPECT_EQ(job.sequence, "scene:stairs_up,frames=60");
  EXPECT_EQ(job.replay_options, (std::vector<std::string>{"--set", "odometry.use_imu=false"}));
  EXPECT_THROW(ParseJob("stairs", "a.list:2"), FileError);
  // A name becomes a folder.
  EXPECT_THROW(ParseJob("../stairs corridor", "a.list:3"), FileError);
}

TEST(EvaluateAllTest, FailsOnWhatGotWorseAndOnWhatIsNotHereUnlessTold) {
  const fs::path folder = fs::path(::testing::TempDir()) / "terrace_evaluate_all";
  fs::create_directories(folder / "out" / "stairs");
  fs::create_directories(folder / "stairs_sequence");
  std::ofstream(folder / "short.list")
      << "# a comment\nstairs stairs_sequence\n\nelsewhere no_such_recording\n";
  const auto measure = [&](double coverage) {
    std::ofstream(folder / "out" / "stairs" / "evaluation.json")
        << "{\"map\": {\"coverage\": " << coverage << "}}";
  };
  EvaluateAllArguments arguments;
  arguments.list = folder / "short.list";
  arguments.output = folder / "out";
  arguments.run = false;
  arguments.skip_missing = true;
  arguments.write_baseline = folder / "baseline.json";
  measure(0.8);
  EXPECT_TRUE(EvaluateAll(arguments));

  arguments.baseline = arguments.write_baseline;
  arguments.write_baseline.reset();
  measure(0.795);  // within the 0.01 that the default tolerates
  EXPECT_TRUE(EvaluateAll(arguments));
  measure(0.7);
  EXPECT_FALSE(EvaluateAll(arguments));
  measure(0.8);
  arguments.skip_missing = false;
  EXPECT_FALSE(EvaluateAll(arguments));
  fs::remove_all(folder);
}

TEST(EvaluateAllTest, RendersASceneOnceThatTwoJobsNeedAtTheSameTime) {
  const fs::path folder = fs::path(::testing::TempDir()) / "terrace_evaluate_all_twice";
  fs::remove_all(folder);
  fs::create_directories(folder);
  std::ofstream(folder / "two.list") << "one scene:flat,frames=2\ntwo scene:flat,frames=2 --threads 1\n";
  const std::string command = std::string(TERRACE_PROGRAM) + " evaluate --all " +
                              (folder / "two.list").string() + " --output " + (folder / "out").string() +
                              " --jobs 2 > " + (folder / "said").string() + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << ReadTextFile(folder / "said");
  EXPECT_TRUE(fs::exists(folder / "out" / "one" / "evaluation.json"));
  EXPECT_TRUE(fs::exists(folder / "out" / "two" / "evaluation.json"));
  EXPECT_TRUE(fs::exists(folder / "out" / "two" / "tracks.jsonl"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace terrace
