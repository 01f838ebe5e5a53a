// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "results/explanations_file.h"
#include "results/replay_result.h"
#include "test/lcmtypes/example_maps.h"

namespace terrace {
namespace {

/// Vertices and feet of staircases are written to the micrometre.
constexpr double kWrittenM = 2e-6;

class ResultFilesRoundTripTest : public ::testing::Test {
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

  std::filesystem::path folder_;
};

TEST_F(ResultFilesRoundTripTest, WritesReasonsWithBytesThatAreNoText) {
  ResultFrame frame;
  frame.reason =
      "/data/Stra\xDF"
      "e/1.png: no such file";
  const std::vector<ResultFrame> read = ReadFramesFile(Write("frames.jsonl", FrameLine(frame) + "\n"));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].reason,
            "/data/Stra\xEF\xBF\xBD"
            "e/1.png: no such file");
}

void ExpectSameRing(const Ring& a, const Ring& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR((a[i] - b[i]).norm(), 0.0, kWrittenM);
}

void ExpectSameStaircase(const Staircase& a, const Staircase& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.num_risers, b.num_risers);
  EXPECT_EQ(a.num_treads, b.num_treads);
  EXPECT_EQ(a.riser_m, b.riser_m);
  EXPECT_EQ(a.tread_m, b.tread_m);
  EXPECT_EQ(a.riser_sigma_m, b.riser_sigma_m);
  EXPECT_EQ(a.tread_sigma_m, b.tread_sigma_m);
  EXPECT_EQ(a.width_m, b.width_m);
  EXPECT_TRUE(a.direction_up_world.isApprox(b.direction_up_world, 1e-12));
  EXPECT_NEAR((a.base_world() - b.base_world()).norm(), 0.0, kWrittenM);
  EXPECT_EQ(a.confidence, b.confidence);
  EXPECT_EQ(a.region_ids, b.region_ids);
}

TEST_F(ResultFilesRoundTripTest, GivesBackTheMap) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const TerrainMap map = ExampleMaps(seed).First(20);
    const TerrainMap back = ReadTerrainMapFile(Write("terrain_map.json", TerrainMapJson(map)));
    EXPECT_EQ(back.t_capture, map.t_capture);
    ASSERT_EQ(back.regions.size(), map.regions.size());
    for (std::size_t i = 0; i < map.regions.size(); ++i) {
      const TerrainRegion& a = *back.regions[i];
      const TerrainRegion& b = *map.regions[i];
      EXPECT_EQ(a.id, b.id);
      EXPECT_EQ(a.revision, b.revision);
      EXPECT_EQ(a.label, b.label);
      EXPECT_EQ(a.confidence, b.confidence);
      EXPECT_EQ(a.why, b.why);
      EXPECT_TRUE(a.plane_world.normal.isApprox(b.plane_world.normal, 1e-12));
      EXPECT_EQ(a.plane_world.offset_m, b.plane_world.offset_m);
      EXPECT_EQ(a.rms_m, b.rms_m);
      EXPECT_EQ(a.area_m2, b.area_m2);
      ExpectSameRing(a.outline_world, b.outline_world);
      ASSERT_EQ(a.holes_world.size(), b.holes_world.size());
      for (std::size_t k = 0; k < a.holes_world.size(); ++k)
        ExpectSameRing(a.holes_world[k], b.holes_world[k]);
      EXPECT_EQ(a.edges, b.edges);
      EXPECT_EQ(a.predicted(), b.predicted());
      EXPECT_EQ(a.staircase_id, b.staircase_id);
      EXPECT_EQ(a.step_index, b.step_index);
      EXPECT_EQ(a.first_seen, b.first_seen);
      EXPECT_EQ(a.last_seen, b.last_seen);
    }
    ASSERT_EQ(back.staircases.size(), map.staircases.size());
    for (std::size_t i = 0; i < map.staircases.size(); ++i)
      ExpectSameStaircase(back.staircases[i], map.staircases[i]);
    EXPECT_EQ(TerrainMapJson(ReadTerrainMapFile(Write("again.json", TerrainMapJson(back)))),
              TerrainMapJson(back))
        << "what has been written and read once does not change any more";
  }
}

TEST_F(ResultFilesRoundTripTest, GivesBackReportsOfStaircases) {
  const StaircaseReport report{{1600000000066666667}, ExampleMaps(2).Stairs(3)};
  const auto back = ReadStaircasesFile(Write("staircases.jsonl", StaircaseLine(report) + "\n\n"));
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].t_capture, report.t_capture);
  ExpectSameStaircase(back[0].staircase, report.staircase);
}

TEST_F(ResultFilesRoundTripTest, GivesBackFramesWithAndWithoutAPose) {
  ResultFrame good;
  good.t_capture = {1600000000066666667};
  good.status = TrackingStatus::kBridging;
  good.reason = "a \"dark\" frame";
  good.covariance = Matrix6d::Random();
  good.latency_ms = 12.5;
  good.map_cells = 1234;
  good.regions = 7;
  good.epoch = 2;
  ResultFrame lost;
  lost.t_capture = {1600000000166666667};
  lost.status = TrackingStatus::kLost;
  const auto back = ReadFramesFile(Write("frames.jsonl", FrameLine(good) + "\n" + FrameLine(lost) + "\n"));
  ASSERT_EQ(back.size(), 2u);
  EXPECT_EQ(back[0].t_capture, good.t_capture);
  EXPECT_EQ(back[0].status, good.status);
  EXPECT_EQ(back[0].reason, good.reason);
  EXPECT_EQ(back[0].covariance, good.covariance);
  EXPECT_EQ(back[0].latency_ms, good.latency_ms);
  EXPECT_EQ(back[0].map_cells, good.map_cells);
  EXPECT_EQ(back[0].regions, good.regions);
  EXPECT_EQ(back[0].epoch, good.epoch);
  EXPECT_EQ(back[1].status, TrackingStatus::kLost);
  EXPECT_FALSE(back[1].covariance);
  EXPECT_FALSE(back[1].latency_ms);
}

TEST_F(ResultFilesRoundTripTest, GivesBackPosesToTheNanosecond) {
  ResultPose pose;
  pose.t_capture = {1600000000000000001};
  pose.T_world_left.linear() =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, -3).normalized()).toRotationMatrix();
  pose.T_world_left.translation() = Eigen::Vector3d(1.5, -2.25, 1e-9);
  const auto back = ReadTrajectoryFile(
      Write("trajectory.tum", std::string(kTrajectoryHeading) + "\n" + TrajectoryLine(pose) + "\n"));
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].t_capture, pose.t_capture);
  EXPECT_TRUE(back[0].T_world_left.isApprox(pose.T_world_left, 1e-8));
}

TEST_F(ResultFilesRoundTripTest, GivesBackTheCamera) {
  ResultCamera camera;
  camera.camera = {640, 480, 400.25, 401.5, 319.5, 239.25, 0.12};
  camera.R_rect_raw = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY()).toRotationMatrix();
  ResultCamera back = ReadCameraFile(Write("camera.json", CameraJson(camera)));
  EXPECT_EQ(back.camera.width, 640);
  EXPECT_EQ(back.camera.height, 480);
  EXPECT_EQ(back.camera.fx, 400.25);
  EXPECT_EQ(back.camera.fy, 401.5);
  EXPECT_EQ(back.camera.cx, 319.5);
  EXPECT_EQ(back.camera.cy, 239.25);
  EXPECT_EQ(back.camera.baseline_m, 0.12);
  EXPECT_EQ(back.R_rect_raw, camera.R_rect_raw);
  EXPECT_FALSE(back.T_body_left);
  camera.T_body_left = Eigen::Isometry3d(Eigen::Translation3d(0.3, 0.0, 0.1));
  back = ReadCameraFile(Write("camera.json", CameraJson(camera)));
  ASSERT_TRUE(back.T_body_left);
  EXPECT_EQ(back.T_body_left->matrix(), camera.T_body_left->matrix());
}

TEST_F(ResultFilesRoundTripTest, GivesBackTheFiguresOfARun) {
  ReplayStats stats;
  stats.frames = 100;
  stats.tracked = 98;
  stats.dropped = 3;
  stats.passed_over = 5;
  stats.lessons_skipped = 2;
  stats.rate_hz = 31.25;
  stats.peak_rss_mib = 120.5;
  stats.map_bytes = 1000000;
  stats.map_cells = 5000;
  stats.map_sha256 = std::string(64, 'a');
  stats.gravity = {Eigen::Vector3d(0.0, 0.6, -0.8), 0.01, GravitySource::kPlane};
  stats.stages["odometry"] = {100, 5.5, 4.0, 5.0, 6.0, 7.0};
  stats.stages["load"] = {101, 1.5, 1.0, 2.0, 3.0, 4.0};
  ReplayStats back = ReadStatsFile(Write("stats.json", StatsJson(stats)));
  EXPECT_EQ(back.frames, 100);
  EXPECT_EQ(back.tracked, 98);
  EXPECT_EQ(back.dropped, 3);
  EXPECT_EQ(back.passed_over, 5);
  EXPECT_EQ(back.lessons_skipped, 2);
  EXPECT_EQ(back.rate_hz, 31.25);
  EXPECT_EQ(back.peak_rss_mib, 120.5);
  EXPECT_EQ(back.map_bytes, 1000000);
  EXPECT_EQ(back.map_cells, 5000);
  EXPECT_EQ(back.map_sha256, stats.map_sha256);
  EXPECT_TRUE(back.gravity.down_world.isApprox(stats.gravity.down_world, 1e-12));
  EXPECT_NEAR(back.gravity.sigma_rad, 0.01, 1e-12);
  EXPECT_EQ(back.gravity.source, GravitySource::kPlane);
  EXPECT_FALSE(back.latency);
  ASSERT_EQ(back.StagesInOrder().size(), 2u);
  EXPECT_EQ(back.StagesInOrder()[0].first, "load");
  EXPECT_EQ(back.StagesInOrder()[1].second.p99_ms, 6.0);
  stats.latency = LatencyMs{1.0, 2.0, 3.0, 4.5};
  back = ReadStatsFile(Write("stats.json", StatsJson(stats)));
  ASSERT_TRUE(back.latency);
  EXPECT_EQ(back.latency->max, 4.5);
}

TEST_F(ResultFilesRoundTripTest, GivesBackTracksToATenthOfAPixel) {
  ResultTracks tracks;
  tracks.frame = 12;
  tracks.t_capture = {1600000000000000001};
  tracks.sightings.is_keyframe = true;
  tracks.sightings.landmarks = {{7, {10.04F, 20.5F}, LandmarkFate::kAgrees},
                                {9, {1.0F, 2.0F}, LandmarkFate::kRejected}};
  const auto back = ReadTracksFile(Write("tracks.jsonl", TracksLine(tracks) + "\n"));
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].frame, 12);
  EXPECT_EQ(back[0].t_capture, tracks.t_capture);
  EXPECT_TRUE(back[0].sightings.is_keyframe);
  ASSERT_EQ(back[0].sightings.landmarks.size(), 2u);
  EXPECT_EQ(back[0].sightings.landmarks[0].landmark, 7);
  EXPECT_NEAR(back[0].sightings.landmarks[0].pixel.x(), 10.0F, 1e-6);
  EXPECT_EQ(back[0].sightings.landmarks[1].fate, LandmarkFate::kRejected);
}

TEST_F(ResultFilesRoundTripTest, GivesBackExplanationsOfRegions) {
  Explanations explanations;
  for (int i = 0; i < kNumLabelRules; ++i) {
    RegionExplanation r;
    r.id = i + 1;
    r.label = static_cast<TerrainLabel>(i % kNumTerrainLabels);
    r.confidence = 0.01 * i;
    r.rule = static_cast<LabelRule>(i);
    r.slope_rad = 0.1 * i;
    r.slope_sigma_rad = 0.001 * i;
    r.offset_sigma_m = 0.002 * i;
    r.rms_m = 0.003 * i;
    r.noise_m = 0.004 * i;
    r.area_m2 = 0.5 * i;
    r.num_observations = i;
    r.text = "region \"" + std::to_string(i) + "\": +- 1 deg.";
    // Every other one has all that may be missing.
    if (i % 2 == 1) {
      r.largest_square_m = 0.5;
      r.nearest_view_m = 1.25;
      r.lowest_step_m = 0.03;
      r.height_m = -0.5;
      r.large = i % 4 == 1;
      r.reachable = i % 4 == 3;
      r.decided_by = 77;
      r.staircase = 3;
      r.step_index = 2;
      r.by_itself = TerrainLabel::kWall;
      r.next_label = TerrainLabel::kObstacle;
      r.num_next = 2;
      r.neighbors = {{4, true, 0.0}, {9, false, -0.17}};
    }
    explanations.regions.push_back(r);
  }
  const Explanations back = ReadExplanationsFile(Write("explanations.jsonl", ExplanationsText(explanations)));
  ASSERT_EQ(back.regions.size(), explanations.regions.size());
  for (std::size_t i = 0; i < back.regions.size(); ++i) {
    const RegionExplanation& a = back.regions[i];
    const RegionExplanation& b = explanations.regions[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.label, b.label);
    EXPECT_EQ(a.confidence, b.confidence);
    EXPECT_EQ(a.rule, b.rule);
    EXPECT_NEAR(a.slope_rad, b.slope_rad, 1e-12);
    EXPECT_NEAR(a.slope_sigma_rad, b.slope_sigma_rad, 1e-12);
    EXPECT_EQ(a.offset_sigma_m, b.offset_sigma_m);
    EXPECT_EQ(a.rms_m, b.rms_m);
    EXPECT_EQ(a.noise_m, b.noise_m);
    EXPECT_EQ(a.area_m2, b.area_m2);
    EXPECT_EQ(a.num_observations, b.num_observations);
    EXPECT_EQ(a.largest_square_m, b.largest_square_m);
    EXPECT_EQ(a.nearest_view_m, b.nearest_view_m);
    EXPECT_EQ(a.lowest_step_m, b.lowest_step_m);
    EXPECT_EQ(a.height_m, b.height_m);
    EXPECT_EQ(a.large, b.large);
    EXPECT_EQ(a.reachable, b.reachable);
    EXPECT_EQ(a.decided_by, b.decided_by);
    EXPECT_EQ(a.staircase, b.staircase);
    EXPECT_EQ(a.step_index, b.step_index);
    EXPECT_EQ(a.by_itself, b.by_itself);
    EXPECT_EQ(a.next_label, b.next_label);
    EXPECT_EQ(a.num_next, b.num_next);
    EXPECT_EQ(a.neighbors, b.neighbors);
    EXPECT_EQ(a.text, b.text);
  }
}

TEST_F(ResultFilesRoundTripTest, GivesBackExplanationsOfStaircases) {
  StaircaseExplanation s;
  s.id = 4;
  s.confidence = 0.9;
  s.num_risers = 6;
  s.num_treads = 5;
  s.riser_m = 0.17;
  s.riser_sigma_m = 0.002;
  s.tread_m = 0.28;
  s.tread_sigma_m = 0.004;
  s.pitch_rad = 0.55;
  s.risers_seen = {1, 2, 5};
  s.treads_seen = {3};
  s.head_region = 8;
  s.num_seen = 4;
  s.num_to_see = 11;
  s.seen_sharply = true;
  s.sides_agree = true;
  s.height_rms_m = 0.003;
  s.text = "staircase 4.";
  const Explanations back = ReadExplanationsFile(Write("explanations.jsonl", ExplanationsText({{}, {s}})));
  EXPECT_TRUE(back.regions.empty());
  ASSERT_EQ(back.staircases.size(), 1u);
  const StaircaseExplanation& a = back.staircases[0];
  EXPECT_EQ(a.id, s.id);
  EXPECT_EQ(a.confidence, s.confidence);
  EXPECT_EQ(a.num_risers, s.num_risers);
  EXPECT_EQ(a.num_treads, s.num_treads);
  EXPECT_EQ(a.riser_m, s.riser_m);
  EXPECT_EQ(a.riser_sigma_m, s.riser_sigma_m);
  EXPECT_EQ(a.tread_m, s.tread_m);
  EXPECT_EQ(a.tread_sigma_m, s.tread_sigma_m);
  EXPECT_NEAR(a.pitch_rad, s.pitch_rad, 1e-12);
  EXPECT_EQ(a.risers_seen, s.risers_seen);
  EXPECT_EQ(a.treads_seen, s.treads_seen);
  EXPECT_EQ(a.foot_region, std::nullopt);
  EXPECT_EQ(a.head_region, s.head_region);
  EXPECT_EQ(a.num_seen, s.num_seen);
  EXPECT_EQ(a.num_to_see, s.num_to_see);
  EXPECT_EQ(a.seen_sharply, s.seen_sharply);
  EXPECT_EQ(a.faces_tile, s.faces_tile);
  EXPECT_EQ(a.sides_agree, s.sides_agree);
  EXPECT_EQ(a.height_rms_m, s.height_rms_m);
  EXPECT_EQ(a.text, s.text);
}

TEST_F(ResultFilesRoundTripTest, RemovesResultsAndNothingElse) {
  Write("stats.json", "{}");
  Write("notes.txt", "mine");
  std::filesystem::create_directories(folder_ / "disparity");
  RemoveResults(folder_);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "stats.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "disparity"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "notes.txt"));
}

}  // namespace
}  // namespace terrace
