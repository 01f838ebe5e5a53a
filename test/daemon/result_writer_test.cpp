// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/result_writer.h"

#include <fstream>
#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/image_file.h"
#include "results/map_file.h"

namespace terrace {
namespace {

using nlohmann::json;
using testing::HasSubstr;
namespace fs = std::filesystem;

class ResultWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    dir_ = fs::path(testing::TempDir()) /
           ("terrace_results_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(dir_);
  }
  void TearDown() override { fs::remove_all(dir_); }

  std::string Text(const std::string& name) const {
    std::stringstream text;
    text << std::ifstream(dir_ / name).rdbuf();
    return text.str();
  }

  ResultCamera Rig() const {
    return {{640, 480, 400, 400, 319.5, 239.5, 0.12}, Eigen::Matrix3d::Identity(), {}};
  }

  static FrameResult Frame(std::int64_t ns, TrackingStatus status) {
    FrameResult result;
    result.pose.t_capture = Timestamp{ns};
    result.pose.status = status;
    result.pose.epoch = 2;
    if (status != TrackingStatus::kTracking) result.pose.reason = "covered lens";
    auto map = std::make_shared<TerrainMap>();
    map->t_capture = Timestamp{ns};
    auto region = std::make_shared<TerrainRegion>();
    region->id = 17;
    region->label = TerrainLabel::kWalkway;
    region->outline_world = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    region->area_m2 = 1.0;
    map->regions.push_back(region);
    result.change.map = map;
    return result;
  }

  fs::path dir_;
};

TEST_F(ResultWriterTest, ATrackedAndABridgedFrameHaveAPoseAndALostOneHasNone) {
  PrepareOutputFolder(dir_, false);
  ResultWriter writer(dir_, Rig(), 0);
  writer.AddFrame(Frame(1'600'000'000'000'000'001, TrackingStatus::kTracking), {});
  writer.AddFrame(Frame(1'600'000'000'100'000'000, TrackingStatus::kBridging), {});
  writer.AddFrame(Frame(1'600'000'000'200'000'000, TrackingStatus::kLost), {});
  writer.Finish({});
  EXPECT_THAT(Text("trajectory.tum"), HasSubstr("\n1600000000.000000001 0.0"));
  EXPECT_THAT(Text("trajectory.tum"), HasSubstr("\n1600000000.100000000 "));
  EXPECT_THAT(Text("trajectory.tum"), testing::Not(HasSubstr("1600000000.2")));
  std::istringstream frames(Text("frames.jsonl"));
  std::string line;
  std::vector<json> lines;
  while (std::getline(frames, line)) lines.push_back(json::parse(line));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[1]["reason"], "covered lens");
  EXPECT_EQ(lines[1]["covariance"].size(), 36u);
  EXPECT_TRUE(lines[2]["covariance"].is_null());
  EXPECT_TRUE(lines[0]["latency_ms"].is_null());
  EXPECT_EQ(lines[2]["epoch"], 2);
  const json stats = json::parse(Text("stats.json"));
  EXPECT_EQ(stats["frames"], 3);
  EXPECT_EQ(stats["tracked"], 2);
}

TEST_F(ResultWriterTest, SaysWhatLiesBeyondEachEdgeOfEachRingAndNullWhereNobodyKnows) {
  TerrainMap map;
  auto region = std::make_shared<TerrainRegion>();
  region->outline_world = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  region->holes_world = {{{0.1, 0.1, 0}, {0.1, 0.2, 0}, {0.2, 0.1, 0}}};
  region->edges.resize(6);
  region->edges[1] = {EdgeKind::kDrop, -0.17, 0.004};
  region->edges[3].kind = EdgeKind::kJoins;
  region->source = RegionSource::kPredicted;
  region->why = "too few points";
  map.regions.push_back(region);
  const json written = json::parse(TerrainMapJson(map))["regions"][0];
  EXPECT_EQ(written["predicted"], true);
  EXPECT_EQ(written["why"], "too few points");
  ASSERT_EQ(written["edges"].size(), 2u);
  ASSERT_EQ(written["edges"][0].size(), 3u);
  ASSERT_EQ(written["edges"][1].size(), 3u);
  EXPECT_EQ(written["edges"][0][0], (json{{"kind", "limit"}, {"step_m", nullptr}, {"sigma_m", nullptr}}));
  EXPECT_EQ(written["edges"][0][1], (json{{"kind", "drop"}, {"step_m", -0.17}, {"sigma_m", 0.004}}));
  EXPECT_EQ(written["edges"][1][0]["kind"], "joins");
}

TEST_F(ResultWriterTest, TheMapHashIsThatOfTheFile) {
  PrepareOutputFolder(dir_, false);
  ResultWriter writer(dir_, Rig(), 0);
  writer.AddFrame(Frame(1, TrackingStatus::kTracking), {});
  writer.Finish({});
  const std::string command =
      "sha256sum '" + (dir_ / "terrain_map.json").string() + "' > '" + (dir_ / "sum").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::string hash = json::parse(Text("stats.json"))["map_sha256"];
  EXPECT_THAT(Text("sum"), testing::StartsWith(hash));
}

TEST_F(ResultWriterTest, AStaircaseHasALineOnlyWhenItAppearsOrChanges) {
  PrepareOutputFolder(dir_, false);
  ResultWriter writer(dir_, Rig(), 0);
  const auto add = [&](std::int64_t ns, double riser_m) {
    FrameResult result = Frame(ns, TrackingStatus::kTracking);
    auto map = std::make_shared<TerrainMap>(*result.change.map);
    map->staircases.push_back({.id = 3, .num_risers = 6, .num_treads = 5, .riser_m = riser_m});
    result.change.map = map;
    writer.AddFrame(result, {});
  };
  add(1, 0.17);
  add(2, 0.17);
  add(3, 0.171);
  writer.Finish({});
  std::istringstream staircases(Text("staircases.jsonl"));
  std::vector<std::int64_t> times;
  for (std::string line; std::getline(staircases, line);) times.push_back(json::parse(line)["t_capture_ns"]);
  EXPECT_THAT(times, testing::ElementsAre(1, 3));
}

TEST_F(ResultWriterTest, SavesDisparityInSixteenBitsOfEveryNthFrame) {
  PrepareOutputFolder(dir_, false);
  ResultWriter writer(dir_, Rig(), 2);
  for (int i = 0; i < 3; ++i) {
    FrameResult result = Frame(100 + i, TrackingStatus::kTracking);
    auto disparity = std::make_shared<DisparityImage>();
    disparity->t_capture = result.pose.t_capture;
    disparity->disparity_px = cv::Mat1f(2, 2, 12.5F);
    disparity->disparity_px(0, 1) = std::numeric_limits<float>::quiet_NaN();
    result.disparity = disparity;
    writer.AddFrame(result, {});
  }
  EXPECT_TRUE(fs::exists(dir_ / "disparity/100.png"));
  EXPECT_FALSE(fs::exists(dir_ / "disparity/101.png"));
  const Gray16Image image = ReadGray16Png(dir_ / "disparity/102.png");
  EXPECT_THAT(image.data, testing::ElementsAre(3200, 0, 3200, 3200));
}

TEST_F(ResultWriterTest, KeepsItsHandsOffAFolderThatHoldsSomething) {
  fs::create_directories(dir_);
  std::ofstream(dir_ / "terrain_map.json") << "old";
  std::ofstream(dir_ / "notes.txt") << "mine";
  EXPECT_THROW(PrepareOutputFolder(dir_, false), OutputError);
  EXPECT_EQ(Text("terrain_map.json"), "old");
  PrepareOutputFolder(dir_, true);
  EXPECT_FALSE(fs::exists(dir_ / "terrain_map.json"));
  EXPECT_EQ(Text("notes.txt"), "mine");
}

}  // namespace
}  // namespace terrace
