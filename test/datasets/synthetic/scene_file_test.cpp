// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene_file.h"

#include <cmath>
#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/terrain_map.h"

namespace terrace::synthetic {
namespace {

using testing::HasSubstr;
using testing::IsSupersetOf;

std::string ProblemsOf(const std::string& yaml) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) /
      ("scene_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".yaml");
  std::ofstream(path) << yaml;
  try {
    LoadScene(path);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST(SceneFileTest, EveryShippedSceneLoads) {
  const std::vector<std::string> names = ShippedScenes();
  EXPECT_THAT(names, IsSupersetOf({"demo", "flat", "stairs_up"}));
  for (const std::string& name : names) EXPECT_NO_THROW(LoadScene(FindScene(name))) << name;
}

TEST(SceneFileTest, TruePolygonsArePlanarCounterClockwiseAndLabelled) {
  for (const std::string& name : ShippedScenes()) {
    const Scene scene = LoadScene(FindScene(name));
    for (const Surface& surface : scene.surfaces) {
      SCOPED_TRACE(name + ": " + surface.name);
      EXPECT_NEAR(surface.plane_world.normal.norm(), 1.0, 1e-9);
      EXPECT_GT(SignedArea(surface.outline_world, surface.plane_world.normal), 0.0);
      double pieces = 0.0;
      for (const Ring& piece : surface.pieces) {
        EXPECT_GT(SignedArea(piece, surface.plane_world.normal), 0.0);
        pieces += SignedArea(piece, surface.plane_world.normal);
        for (const Eigen::Vector3d& p : piece) EXPECT_NEAR(surface.plane_world.SignedDistance(p), 0.0, 1e-6);
      }
      double holes = 0.0;
      for (const Ring& hole : surface.holes_world) {
        EXPECT_GT(SignedArea(hole, surface.plane_world.normal), 0.0);
        holes += SignedArea(hole, surface.plane_world.normal);
        for (const Eigen::Vector3d& p : hole) EXPECT_NEAR(surface.plane_world.SignedDistance(p), 0.0, 1e-3);
      }
      for (const Eigen::Vector3d& p : surface.outline_world) {
        EXPECT_NEAR(surface.plane_world.SignedDistance(p), 0.0, 1e-6);
      }
      // Light meets the whole outline, or the outline less its windows; what stands on a floor covers its
      // hole.
      const double area = SignedArea(surface.outline_world, surface.plane_world.normal);
      EXPECT_TRUE(std::abs(pieces - area) < 1e-6 || std::abs(pieces - (area - holes)) < 1e-6)
          << pieces << " " << area;
      EXPECT_TRUE(surface.label == "other" || TerrainLabelFromName(surface.label).has_value())
          << surface.label;
      EXPECT_GT(surface.image_id, 0);
    }
  }
}

TEST(SceneFileTest, StaircasesKnowTheirPolygonsAndTheirSize) {
  const Scene scene = LoadScene(FindScene("demo"));
  ASSERT_EQ(scene.staircases.size(), 1u);
  const TrueStaircase& truth = scene.staircases[0].truth;
  EXPECT_EQ(truth.num_risers, 6);
  EXPECT_EQ(truth.polygon_ids.size(), 11u);
  EXPECT_NEAR((truth.foot_edge_world[0] - truth.foot_edge_world[1]).norm(), truth.width_m, 1e-9);
  EXPECT_NEAR(truth.head_edge_world[0].z() - truth.foot_edge_world[0].z(), truth.num_risers * truth.riser_m,
              1e-9);
  for (const int id : truth.polygon_ids) {
    const Surface& surface = scene.surfaces[static_cast<std::size_t>(id - 1)];
    EXPECT_EQ(surface.image_id, id);
    const bool riser = surface.label == "stair_riser";
    const Eigen::Vector3d& normal = surface.plane_world.normal;
    EXPECT_NEAR(riser ? -normal.dot(truth.direction_up_world) : normal.z(), 1.0, 1e-9);
  }
}

TEST(SceneFileTest, EveryProblemIsNamedWithFileKeyValueAndRule) {
  const std::string problems = ProblemsOf(
      "rate_hz: -3\n"
      "colour: red\n"
      "materials: {stone: {pattern: granite}}\n"
      "objects:\n"
      "  - {kind: staircase, risers: 1, material: marble}\n"
      "  - {kind: sofa}\n"
      "  - {kind: floor, min_m: [0, 0], max_m: [1, x]}\n"
      "motion: {kind: fly}\n");
  EXPECT_THAT(problems, HasSubstr(".yaml: rate_hz is '-3', must be a number from 0.1 to 200"));
  EXPECT_THAT(problems, HasSubstr("colour is not a key"));
  EXPECT_THAT(problems, HasSubstr("materials.stone.pattern is 'granite', must be one of plain"));
  EXPECT_THAT(problems, HasSubstr("objects[0].risers is '1', must be a whole number from 2 to 100"));
  EXPECT_THAT(problems, HasSubstr("objects[0].material is 'marble', must be one of the file's materials"));
  EXPECT_THAT(problems, HasSubstr("objects[1].kind is 'sofa'"));
  EXPECT_THAT(problems, HasSubstr("objects[2].max_m is '[1, x]', must be 2 numbers"));
  EXPECT_THAT(problems, HasSubstr("motion.kind is 'fly', must be walk, stand, creep or turn_on_spot"));
  EXPECT_THAT(problems, HasSubstr("motion.path_m must hold at least the starting point"));
}

TEST(SceneFileTest, AFileThatIsNoSceneIsRefused) {
  EXPECT_THAT(ProblemsOf("a: [1, 2"), HasSubstr("not valid YAML"));
  EXPECT_THAT(ProblemsOf("- 1\n"), HasSubstr("must be a YAML map"));
  EXPECT_THROW(FindScene("no_such_scene"), SceneError);
  EXPECT_THROW(LoadScene("/nowhere/scene.yaml"), SceneError);
}

TEST(SceneFileTest, RollsTheCameraAndBuildsTheRightOneOtherwiseThanItsCalibrationKnows) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "scene_cameras.yaml";
  std::ofstream(path)
      << "materials: {m: {}}\nobjects: [{kind: floor, name: f, min_m: [0, 0], max_m: [1, 1], "
         "material: m}]\ncamera: {fx: 400, pitch_down_deg: 0, roll_deg: 90, right_below: true, "
         "right_roll_deg: 1, right_row_shift_px: 2, right_late_ms: 5}\nmotion: {path_m: [[0, 0]]}\n";
  const Scene scene = LoadScene(path);
  // Clockwise seen from behind: the image's right is down, its top to the robot's right.
  const Eigen::Matrix3d R_body_left = scene.mounting.T_body_left().linear();
  EXPECT_TRUE((R_body_left * Eigen::Vector3d::UnitX()).isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE((R_body_left * Eigen::Vector3d::UnitY()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_TRUE(scene.right.below);
  EXPECT_DOUBLE_EQ(scene.right.late_s, 0.005);
  // Far things, where the right camera sees them.
  const auto seen = [&](double u, double v) {
    const Eigen::Vector3d p =
        scene.right.Turn(400.0).transpose() * Eigen::Vector3d(u / 400.0, v / 400.0, 1.0);
    return Eigen::Vector2d(400.0 * p.x() / p.z(), 400.0 * p.y() / p.z());
  };
  EXPECT_TRUE(seen(0, 0).isApprox(Eigen::Vector2d(0, 2), 1e-9));
  EXPECT_NEAR(seen(100, 0).y() - 2.0, 100.0 * std::sin(M_PI / 180.0), 0.02) << "clockwise: right is lower";
}

}  // namespace
}  // namespace terrace::synthetic
