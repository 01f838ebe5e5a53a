// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ring_log.h"

#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test/datasets/temporary_folder.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

constexpr std::int64_t kSecond = 1'000'000;

RingLogConfig SmallRing() {
  RingLogConfig config;
  config.span_s = 30.0;
  config.segment_s = 5.0;
  config.repeated_channels = {"CALIBRATION"};
  return config;
}

std::vector<LcmEvent> Events(const fs::path& path) {
  LcmEventReader reader(path);
  std::vector<LcmEvent> events;
  LcmEvent event;
  while (reader.Next(&event)) events.push_back(event);
  EXPECT_EQ(reader.num_skipped_bytes(), 0);
  return events;
}

TEST(RingLogTest, KeepsTheSpanAndForgetsWhatIsOlder) {
  const TemporaryFolder folder;
  RingLog ring(folder.path() / "ring", SmallRing());
  for (int i = 0; i < 1000; ++i) ring.Add(i * kSecond / 10, "IMAGES", Bytes{std::uint8_t(i & 0xff)});
  EXPECT_GE(ring.span_s(), 30.0);
  EXPECT_LE(ring.span_s(), 40.1);
  JoinLogs(ring.Take("kept"), folder.path() / "kept.lcmlog");
  const std::vector<LcmEvent> events = Events(folder.path() / "kept.lcmlog");
  ASSERT_GE(events.size(), 300u);
  EXPECT_EQ(events.back().utime, 999 * kSecond / 10);
  for (std::size_t i = 1; i < events.size(); ++i)
    EXPECT_EQ(events[i].utime - events[i - 1].utime, kSecond / 10);
  EXPECT_FALSE(fs::exists(folder.path() / "ring" / "kept")) << "parts are removed once they are joined";
}

TEST(RingLogTest, BeginsEachFileWithTheCalibrationSoThatItCanBeReplayed) {
  const TemporaryFolder folder;
  RingLog ring(folder.path() / "ring", SmallRing());
  ring.Add(0, "CALIBRATION", Bytes{7});
  for (int i = 1; i < 100; ++i) ring.Add(i * kSecond, "IMAGES", Bytes{1, 2});
  const std::vector<fs::path> parts = ring.Take("kept");
  ASSERT_GE(parts.size(), 6u);
  for (const fs::path& part : parts) {
    const std::vector<LcmEvent> events = Events(part);
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(events.front().channel, "CALIBRATION");
    EXPECT_EQ(events.front().data, Bytes{7});
  }
}

TEST(RingLogTest, StaysBelowItsSize) {
  const TemporaryFolder folder;
  RingLogConfig config = SmallRing();
  config.max_bytes = 100'000;
  RingLog ring(folder.path() / "ring", config);
  for (int i = 0; i < 300; ++i) ring.Add(i * kSecond / 10, "IMAGES", Bytes(1000));
  EXPECT_LE(ring.num_bytes(), 100'000 + 50 * 1000) << "and one file beyond it";
}

TEST(RingLogTest, GoesOnWithWhatAnEarlierRunLeft) {
  const TemporaryFolder folder;
  {
    RingLog ring(folder.path() / "ring", SmallRing());
    for (int i = 0; i < 20; ++i) ring.Add(i * kSecond, "IMAGES", Bytes{1});
  }
  std::ofstream(folder.path() / "ring" / "notes.txt") << "not a part of it";
  RingLog ring(folder.path() / "ring", SmallRing());
  ring.Add(20 * kSecond, "IMAGES", Bytes{2});
  EXPECT_EQ(ring.span_s(), 20.0);
  JoinLogs(ring.Take("kept"), folder.path() / "kept.lcmlog");
  EXPECT_EQ(Events(folder.path() / "kept.lcmlog").size(), 21u);
}

TEST(RingLogTest, SurvivesAClockThatIsSetBack) {
  const TemporaryFolder folder;
  RingLog ring(folder.path() / "ring", SmallRing());
  for (int i = 0; i < 10; ++i) ring.Add((100 + i) * kSecond, "IMAGES", Bytes{1});
  for (int i = 0; i < 10; ++i) ring.Add((50 + i) * kSecond, "IMAGES", Bytes{2});
  std::size_t num_events = 0;
  for (const fs::path& part : ring.Take("kept")) num_events += Events(part).size();
  EXPECT_EQ(num_events, 20u);
}

TEST(RingLogTest, LeavesNoHalfLogWhereItCannotBeWritten) {
  const TemporaryFolder folder;
  RingLog ring(folder.path() / "ring", SmallRing());
  ring.Add(0, "IMAGES", Bytes{1});
  const std::vector<fs::path> parts = ring.Take("kept");
  EXPECT_THROW(JoinLogs(parts, folder.path() / "missing" / "kept.lcmlog"), std::exception);
  EXPECT_TRUE(fs::exists(parts.front()));
}

}  // namespace
}  // namespace terrace
