// SPDX-License-Identifier: BSD-3-Clause
#include "results/replay_result.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file_bytes.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;

class ResultFilesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("terrace_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  template <typename Read>
  std::string ErrorOf(Read read) {
    try {
      read();
    } catch (const FileError& e) {
      return e.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

constexpr const char* kMap = R"({"format": "terrace-map", "version": 1, "t_capture_ns": 12, "frame": "world",
  "regions": [{"id": 17, "revision": 4, "label": "stair_tread", "confidence": 0.97, "normal": [0,0,1],
    "offset_m": 0.17, "rms_m": 0.003, "area_m2": 0.75, "outline": [[0,0,0.17],[1,0,0.17],[1,1,0.17],[0,1,0.17]],
    "holes": [[[0.25,0.25,0.17],[0.25,0.75,0.17],[0.75,0.75,0.17],[0.75,0.25,0.17]]],
    "staircase": 3, "step_index": 1, "first_seen_ns": 5, "last_seen_ns": 9, "predicted": true, "why": "",
    "edges": [[{"kind": "drop", "step_m": -0.17, "sigma_m": 0.004}, {"kind": "limit", "step_m": null, "sigma_m": null},
               {"kind": "rise", "step_m": 0.17, "sigma_m": null}, {"kind": "joins", "step_m": null, "sigma_m": null}],
              [{"kind": "limit", "step_m": null, "sigma_m": null}, {"kind": "limit", "step_m": null, "sigma_m": null},
               {"kind": "limit", "step_m": null, "sigma_m": null}, {"kind": "drop", "step_m": null, "sigma_m": null}]]}],
  "staircases": [{"id": 3, "num_steps": 6, "num_treads": 5, "riser_m": 0.17, "tread_m": 0.28, "width_m": 1.4,
    "direction_world": [1,0,0], "base_world": [7.2,0,0], "confidence": 0.98, "region_ids": [17]}]})";

TEST_F(ResultFilesTest, ReadsTimesToTheNanosecond) {
  const auto poses =
      ReadTrajectoryFile(Write("trajectory.tum",
                               "# timestamp tx ty tz qx qy qz qw\n"
                               "1403636584.763555584 1 2 3 0 0 0 1\n1403636584.813555456 1 2 4 0 0 1 0\n"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].t_capture.ns, 1403636584763555584);
  EXPECT_EQ(poses[1].t_capture.ns, 1403636584813555456);
  EXPECT_DOUBLE_EQ(poses[1].T_world_left.translation().z(), 4.0);
  EXPECT_NEAR(poses[1].T_world_left.linear()(0, 0), -1.0, 1e-12);
}

TEST_F(ResultFilesTest, ReadsRegionsAndStaircasesOfAMap) {
  const TerrainMap map = ReadTerrainMapFile(Write("terrain_map.json", kMap));
  ASSERT_EQ(map.regions.size(), 1u);
  EXPECT_EQ(map.regions[0]->label, TerrainLabel::kStairTread);
  EXPECT_EQ(map.regions[0]->holes_world.size(), 1u);
  EXPECT_EQ(map.regions[0]->staircase_id, 3);
  EXPECT_TRUE(map.regions[0]->predicted());
  ASSERT_EQ(map.regions[0]->edges.size(), 8u);
  EXPECT_EQ(map.regions[0]->edges[0], (RegionEdge{EdgeKind::kDrop, -0.17, 0.004}));
  EXPECT_EQ(map.regions[0]->edges[2], (RegionEdge{EdgeKind::kRise, 0.17, {}}));
  EXPECT_EQ(map.regions[0]->edges[7].kind, EdgeKind::kDrop);
  ASSERT_EQ(map.staircases.size(), 1u);
  const Staircase& staircase = map.staircases[0];
  EXPECT_TRUE(staircase.base_world().isApprox(Eigen::Vector3d(7.2, 0, 0)));
  // Looking along +x the left end lies at +y; five treads of 0.28 m and six risers of 0.17 m.
  EXPECT_TRUE(staircase.foot_edge_world[0].isApprox(Eigen::Vector3d(7.2, 0.7, 0)));
  EXPECT_TRUE(staircase.head_edge_world[0].isApprox(Eigen::Vector3d(8.6, 0.7, 1.02)));
}

TEST_F(ResultFilesTest, NamesFilePlaceAndRuleOfWhatIsWrong) {
  std::string text = kMap;
  text.replace(text.find("stair_tread"), 11, "stair_trade");
  const auto wrong_label = Write("terrain_map.json", text);
  EXPECT_THAT(ErrorOf([&] { ReadTerrainMapFile(wrong_label); }),
              HasSubstr("terrain_map.json regions[0] label: 'stair_trade' is not a label"));
  text = kMap;
  text.replace(text.find("rise"), 4, "wall");
  const auto wrong_edge = Write("terrain_map.json", text);
  EXPECT_THAT(ErrorOf([&] { ReadTerrainMapFile(wrong_edge); }),
              HasSubstr("kind: must be limit, drop, rise or joins"));

  const auto backwards = Write("trajectory.tum", "2.0 0 0 0 0 0 0 1\n1.0 0 0 0 0 0 0 1\n");
  EXPECT_THAT(ErrorOf([&] { ReadTrajectoryFile(backwards); }), HasSubstr("trajectory.tum:2: time must rise"));

  const auto short_line = Write("frames.jsonl", R"({"t_capture_ns": 1, "status": "tracking"})");
  EXPECT_THAT(ErrorOf([&] { ReadFramesFile(short_line); }), HasSubstr("frames.jsonl:1: reason is missing"));

  EXPECT_THAT(ErrorOf([&] { ReadStatsFile(folder_ / "stats.json"); }), HasSubstr("stats.json: no such file"));
}

TEST_F(ResultFilesTest, ReadsFramesWithAndWithoutCovariance) {
  std::string numbers = "1";
  for (int i = 2; i <= 36; ++i) numbers += "," + std::to_string(i);
  const auto frames = ReadFramesFile(Write(
      "frames.jsonl", "{\"t_capture_ns\": 1, \"status\": \"tracking\", \"reason\": \"\", \"covariance\": [" +
                          numbers +
                          "], \"latency_ms\": 7.5, \"map_cells\": 3, \"regions\": 2}\n"
                          "{\"t_capture_ns\": 2, \"status\": \"lost\", \"reason\": \"dark\", "
                          "\"covariance\": null, \"latency_ms\": null, \"map_cells\": 3, \"regions\": 2}\n"));
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_DOUBLE_EQ((*frames[0].covariance)(1, 0), 7.0);  // row-major
  EXPECT_DOUBLE_EQ(*frames[0].latency_ms, 7.5);
  EXPECT_EQ(frames[1].status, TrackingStatus::kLost);
  EXPECT_FALSE(frames[1].covariance);
}

TEST_F(ResultFilesTest, ListsSavedDisparitiesByTimeAndNothingElse) {
  std::filesystem::create_directories(folder_ / "disparity");
  for (const char* name : {"20.png", "3.png", "20_confidence.png", "notes.txt"}) {
    Write(std::string("disparity/") + name, "");
  }
  const auto images = SavedDisparities(folder_);
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images.begin()->first.ns, 3);
}

}  // namespace
}  // namespace terrace
