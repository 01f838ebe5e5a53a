// SPDX-License-Identifier: BSD-3-Clause
// From files to files: a sequence with truth and a result are written to a folder, evaluated, and what
// programs and people read of it is checked.
#include "evaluation/evaluation.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/file_bytes.h"
#include "datasets/image_file.h"
#include "datasets/npz_file.h"
#include "evaluation/evaluation_text.h"
#include "evaluation/report.h"
#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

Json JsonOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json JsonOf(const Ring& ring) {
  Json json = Json::array();
  for (const Eigen::Vector3d& p : ring) json.push_back(JsonOf(p));
  return json;
}

class EvaluationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("terrace_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_ / "sequence");
    std::filesystem::create_directories(folder_ / "result");
    WriteSequence();
    WriteResult();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void Write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

  /// Twenty poses 10 cm apart along x.
  std::string Poses() const {
    std::string text;
    for (int i = 0; i < 20; ++i) {
      text +=
          "16000000" + std::to_string(10 + i) + ".000000000 " + std::to_string(0.1 * i) + " 0 0 0 0 0 1\n";
    }
    return text;
  }

  void WriteSequence() {
    Write("sequence/groundtruth_tum.txt", Poses());
    Json truth = {{"polygons", Json::array()}, {"staircases", Json::array()}, {"objects", Json::array()}};
    std::map<std::string, NpyArray> cells;
    for (const TruePolygon& polygon : world_.polygons) {
      truth["polygons"].push_back({{"id", polygon.id},
                                   {"name", polygon.name},
                                   {"label", polygon.label},
                                   {"normal", JsonOf(polygon.plane_world.normal)},
                                   {"offset", polygon.plane_world.offset_m},
                                   {"vertices", JsonOf(polygon.outline_world)},
                                   {"holes", Json::array()},
                                   {"area", polygon.area_m2},
                                   {"staircase_id", nullptr},
                                   {"step_index", nullptr},
                                   {"detail", false}});
      const ObservedCells& seen = polygon.observed;
      const double frame[9] = {seen.axis_x.x(),   seen.axis_x.y(),   seen.axis_x.z(),
                               seen.axis_y.x(),   seen.axis_y.y(),   seen.axis_y.z(),
                               seen.origin_m.x(), seen.origin_m.y(), seen.cell_m};
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(frame);
      cells["frame_" + std::to_string(polygon.id)] = {"<f8", {9}, {bytes, bytes + sizeof(frame)}};
      cells["mask_" + std::to_string(polygon.id)] = {
          "|b1", {static_cast<std::size_t>(seen.nx), static_cast<std::size_t>(seen.ny)}, seen.seen};
    }
    for (const TrueStaircase& staircase : world_.staircases) {
      truth["staircases"].push_back(
          {{"id", staircase.id},
           {"n_risers", staircase.num_risers},
           {"n_treads", staircase.num_treads},
           {"riser", staircase.riser_m},
           {"tread", staircase.tread_m},
           {"width", staircase.width_m},
           {"up_direction", JsonOf(staircase.direction_up_world)},
           {"foot_edge", {JsonOf(staircase.foot_edge_world[0]), JsonOf(staircase.foot_edge_world[1])}},
           {"top_edge", {JsonOf(staircase.head_edge_world[0]), JsonOf(staircase.head_edge_world[1])}},
           {"polygon_ids", staircase.polygon_ids}});
    }
    Write("sequence/ground_truth.json", truth.dump());
    WriteNpzFile(folder_ / "sequence" / "observed_cells.npz", cells);
  }

  void WriteResult() {
    Write("result/trajectory.tum", Poses());
    Json map = {{"format", "terrace-map"},  {"version", 1},
                {"t_capture_ns", 0},        {"frame", "world"},
                {"regions", Json::array()}, {"staircases", Json::array()}};
    for (const auto& region : MapOf(world_).regions) {
      map["regions"].push_back({{"id", region->id},
                                {"revision", 0},
                                {"label", Name(region->label)},
                                {"confidence", 1.0},
                                {"normal", JsonOf(region->plane_world.normal)},
                                {"offset_m", region->plane_world.offset_m},
                                {"rms_m", 0.0},
                                {"area_m2", region->area_m2},
                                {"outline", JsonOf(region->outline_world)},
                                {"holes", Json::array()},
                                {"staircase", nullptr},
                                {"step_index", nullptr},
                                {"first_seen_ns", 0},
                                {"last_seen_ns", 0}});
    }
    Write("result/terrain_map.json", map.dump());
    Write("result/staircases.jsonl", "");
    std::string frames;
    for (int i = 0; i < 20; ++i) {
      // Latency grows by 2 ms with each 1000 cells, and by 10 ms with each 100 regions.
      frames += Json{{"t_capture_ns", 1'600'000'010'000'000'000 + i * 1'000'000'000LL},
                     {"status", i == 7 || i == 8 ? "bridging" : "tracking"},
                     {"reason", ""},
                     {"covariance", std::vector<double>(36, 0.0)},
                     {"latency_ms", 30.0 + 2.0 * i},
                     {"map_cells", 1000 * i},
                     {"regions", 20 * i}}
                    .dump() +
                "\n";
    }
    Write("result/frames.jsonl", frames);
    Write("result/camera.json",
          R"({"width": 640, "height": 480, "fx": 400, "fy": 400, "cx": 319.5, "cy": 239.5,
      "baseline_m": 0.12, "R_rect_raw": [1,0,0,0,1,0,0,0,1], "T_body_left": null})");
    Write("result/stats.json",
          R"({"frames": 20, "tracked": 20, "dropped": 0, "rate_hz": 9.5, "peak_rss_mib": 120,
      "map_bytes": 1, "map_cells": 19000, "map_sha256": "", "gravity_world": [0,0,-1], "gravity_sigma_deg": 0.1,
      "gravity_source": "imu", "latency_ms": null, "stages": {"labels": {"count": 20, "cpu_ms_mean": 1, "p50_ms": 1,
      "p90_ms": 2, "p99_ms": 3, "max_ms": 4}, "disparity": {"count": 20, "cpu_ms_mean": 40, "p50_ms": 40,
      "p90_ms": 42, "p99_ms": 43, "max_ms": 44}}})");
  }

  Evaluation Evaluate() const { return EvaluateResult(folder_ / "result", folder_ / "sequence"); }

  TrueScene world_ = SmallWorld();
  std::filesystem::path folder_;
};

TEST_F(EvaluationTest, WritesTheFiguresThatOtherProgramsRead) {
  const Json json = Json::parse(ToJson(Evaluate()));
  EXPECT_NEAR(json["trajectory"]["ate_rmse_m"].get<double>(), 0.0, 1e-9);
  EXPECT_EQ(json["trajectory"]["coverage"], 1.0);
  EXPECT_NEAR(json["trajectory"]["rpe1m_pct"].get<double>(), 0.0, 1e-6);
  EXPECT_TRUE(json["trajectory"]["rpe5m_pct"].is_null());  // the path is 1.9 m
  EXPECT_NEAR(json["map"]["coverage"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(json["map"]["ghost_area"], 0.0);
  EXPECT_NEAR(json["map"]["support_plane_rms_m"].get<double>(), 0.0, 1e-9);
  for (const char* label : {"walkway", "wall", "obstacle", "stair_tread", "stair_riser"}) {
    EXPECT_NEAR(json["map"]["iou"][label].get<double>(), 1.0, 1e-9) << label;
  }
  EXPECT_NEAR(json["feet"]["unsupported_pct"].get<double>(), 0.0, 1e-9);
  EXPECT_TRUE(json["feet"]["offered_pct"].is_null());  // no label image says what was well seen
  EXPECT_EQ(json["staircases"]["recall"], 0.0);        // none was reported
  EXPECT_EQ(json["time"]["bridged"], 2);
  EXPECT_NEAR(json["time"]["latency_growth"]["ms_per_1000_cells"].get<double>(), 2.0, 1e-9);
  EXPECT_NEAR(json["time"]["latency_growth"]["ms_per_100_regions"].get<double>(), 10.0, 1e-9);
  EXPECT_FALSE(json.contains("disparity"));
}

TEST_F(EvaluationTest, SaysWhatCouldNotBeMeasured) {
  std::filesystem::remove(folder_ / "sequence" / "ground_truth.json");
  std::filesystem::remove(folder_ / "sequence" / "groundtruth_tum.txt");
  const Evaluation evaluation = Evaluate();
  EXPECT_FALSE(evaluation.trajectory);
  EXPECT_FALSE(evaluation.map);
  EXPECT_EQ(evaluation.notes.size(), 2u);
  EXPECT_THAT(ToTable(evaluation), HasSubstr("the sequence has no true poses"));
  EXPECT_THROW(EvaluateResult(folder_ / "result", folder_ / "nowhere"), FileError);
}

TEST_F(EvaluationTest, MovesTheMapByTheTrajectory) {
  // The same result in a world that is turned by 90 deg and shifted.
  std::string text;
  for (int i = 0; i < 20; ++i) {
    text += "16000000" + std::to_string(10 + i) + ".000000000 7 " + std::to_string(0.1 * i) +
            " 0 0 0 0.7071067811865476 0.7071067811865476\n";
  }
  Write("result/trajectory.tum", text);
  const Evaluation evaluation = Evaluate();
  Eigen::Isometry3d T_result_true = Eigen::Isometry3d::Identity();
  T_result_true.linear() = Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_result_true.translation() = Eigen::Vector3d(7, 0, 0);
  EXPECT_TRUE(evaluation.map->T_true_result.isApprox(T_result_true.inverse(), 1e-9));
}

TEST_F(EvaluationTest, ReportsOnOnePageThatNeedsNoNetwork) {
  world_.polygons[0].name = "floor <b>&";
  WriteSequence();
  const std::string report = ToReport(Evaluate());
  EXPECT_THAT(report, HasSubstr("<svg"));
  EXPECT_THAT(report, HasSubstr("floor &lt;b&gt;&amp;"));
  EXPECT_THAT(report, HasSubstr("Confusion"));
  EXPECT_THAT(report, Not(HasSubstr("http")));
  EXPECT_THAT(report, Not(HasSubstr("<script")));
  // In the order in which a frame passes them, not of the alphabet or the file.
  EXPECT_LT(report.find(">disparity</text>"), report.find(">labels</text>"));
}

TEST_F(EvaluationTest, ShowsTheTracksOnTheImagesOrSaysHowToGetThem) {
  EXPECT_THAT(ToReport(Evaluate()), HasSubstr("--save-tracks"));
  std::filesystem::create_directories(folder_ / "result" / "tracks");
  WritePng(folder_ / "result/tracks/1600000012000000000.png", {4, 3, std::vector<std::uint8_t>(12, 99)});
  Write(
      "result/tracks.jsonl",
      "{\"frame\": 1, \"t_capture_ns\": 1600000011000000000, \"keyframe\": true, \"agrees\": [[7, 1, 2]], "
      "\"rejected\": [], \"created\": []}\n"
      "{\"frame\": 2, \"t_capture_ns\": 1600000012000000000, \"keyframe\": false, \"agrees\": [[7, 2, 2.5]], "
      "\"rejected\": [[8, 3, 1]], \"created\": []}\n");
  const std::string report = ToReport(Evaluate());
  EXPECT_THAT(report, Not(HasSubstr("--save-tracks")));
  EXPECT_THAT(report, HasSubstr("frame 2, 2.00 s: 1 agree, 1 rejected<"));
  EXPECT_THAT(report, HasSubstr("href=\"data:image/jpeg;base64,"));
  EXPECT_THAT(report, HasSubstr("M1.0 2.0L2.0 2.5"));  // the trail
  EXPECT_THAT(report, HasSubstr("M1.0 2.0h0"));        // its keyframe
  EXPECT_THAT(report, Not(HasSubstr("http")));
}

}  // namespace
}  // namespace terrace
