// SPDX-License-Identifier: BSD-3-Clause
#include "tools/family_jobs.h"

#include <gtest/gtest.h>

#include "core/file_bytes.h"

namespace terrace {
namespace {

TEST(FamilyJobsTest, MakesAJobOfEverySeed) {
  const std::vector<EvaluationJob> jobs =
      ExpandFamily(ParseJob("stairs family:up,seeds=7-9,frames=60 --threads 1", "list:1"), "list:1");
  ASSERT_EQ(jobs.size(), 3u);
  EXPECT_EQ(jobs[0].name, "stairs_7");
  EXPECT_EQ(jobs[2].name, "stairs_9");
  EXPECT_EQ(jobs[1].sequence, "scene:family:up,seed=8,frames=60");
  EXPECT_EQ(jobs[1].replay_options, (std::vector<std::string>{"--threads", "1"}));
  EXPECT_EQ(jobs[1].group, "stairs");
}

TEST(FamilyJobsTest, LeavesOtherLinesAlone) {
  const std::vector<EvaluationJob> jobs = ExpandFamily(ParseJob("demo scene:demo", "list:1"), "list:1");
  ASSERT_EQ(jobs.size(), 1u);
  EXPECT_EQ(jobs[0].sequence, "scene:demo");
  EXPECT_TRUE(jobs[0].group.empty());
}

TEST(FamilyJobsTest, RefusesSeedsThatAreNone) {
  for (const char* line : {"a family:up", "a family:up,seeds=", "a family:up,seeds=x",
                           "a family:up,seeds=3-2", "a family:up,seeds=1-", "a family:up,seeds=1-99999999"}) {
    EXPECT_THROW(ExpandFamily(ParseJob(line, "list:1"), "list:1"), FileError) << line;
  }
  EXPECT_EQ(ExpandFamily(ParseJob("a family:up,seeds=5", "list:1"), "list:1").size(), 1u);
}

TEST(FamilyJobsTest, KnowsTheFamiliesByNameAndAllOfThem) {
  EXPECT_EQ(FamilyLines({"up", "drop"}, "1-2").size(), 2u);
  EXPECT_EQ(FamilyLines({"up"}, "1-2").front().sequence, "family:up,seeds=1-2");
  EXPECT_GE(FamilyLines({"all"}, "1").size(), 11u);
  EXPECT_THROW(FamilyLines({"escalator"}, "1"), FileError);
}

}  // namespace
}  // namespace terrace
