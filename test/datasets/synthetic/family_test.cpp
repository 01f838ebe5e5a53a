// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/family.h"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "datasets/synthetic/ray_scene.h"
#include "datasets/synthetic/scene_file.h"
#include "datasets/synthetic/synthesis.h"

namespace terrace::synthetic {
namespace {

constexpr std::uint32_t kNumSeeds = 12;

/// Calls use(family, scene) for some places of every family.
template <typename Use>
void ForEachPlace(Use use) {
  for (const std::string& family : FamilyNames()) {
    for (std::uint32_t seed = 1; seed <= kNumSeeds; ++seed) {
      SCOPED_TRACE(family + " " + std::to_string(seed));
      use(family, DrawPlace(family, seed));
    }
  }
}

bool Same(const Scene& a, const Scene& b) {
  if (a.surfaces.size() != b.surfaces.size()) return false;
  for (std::size_t i = 0; i < a.surfaces.size(); ++i) {
    if (a.surfaces[i].outline_world != b.surfaces[i].outline_world) return false;
    if (a.surfaces[i].label != b.surfaces[i].label) return false;
  }
  return a.motion.path == b.motion.path && a.motion.speed_mps == b.motion.speed_mps &&
         a.mounting.pitch_down_rad == b.mounting.pitch_down_rad &&
         a.materials.front().seed == b.materials.front().seed;
}

TEST(FamilyTest, DrawsTheSamePlaceFromTheSameSeedAndAnotherFromAnother) {
  for (const std::string& family : FamilyNames()) {
    EXPECT_TRUE(Same(DrawPlace(family, 5), DrawPlace(family, 5))) << family;
    EXPECT_FALSE(Same(DrawPlace(family, 5), DrawPlace(family, 6))) << family;
  }
  EXPECT_THROW(DrawPlace("escalator", 1), SceneError);
}

TEST(FamilyTest, MakesPlanarSurfacesThatTheirPiecesLieIn) {
  ForEachPlace([](const std::string&, const Scene& scene) {
    for (const Surface& surface : scene.surfaces) {
      for (const Eigen::Vector3d& p : surface.outline_world)
        EXPECT_NEAR(surface.plane_world.SignedDistance(p), 0.0, 1e-9) << surface.name;
      for (const Ring& piece : surface.pieces) {
        for (const Eigen::Vector3d& p : piece)
          EXPECT_NEAR(surface.plane_world.SignedDistance(p), 0.0, 1e-9) << surface.name;
      }
    }
  });
}

TEST(FamilyTest, HasTheStaircasesOfItsName) {
  const std::map<std::string, std::size_t> expected{{"up", 1},    {"up_free", 1},     {"down", 1},
                                                    {"open", 1},  {"spiral_left", 1}, {"spiral_right", 1},
                                                    {"dogleg", 2}};
  ForEachPlace([&](const std::string& family, const Scene& scene) {
    const auto found = expected.find(family);
    EXPECT_EQ(scene.staircases.size(), found == expected.end() ? 0 : found->second);
    for (const SceneStaircase& stairs : scene.staircases) {
      EXPECT_GE(stairs.truth.num_risers, 3);
      EXPECT_GE(stairs.truth.riser_m, 0.10);
      EXPECT_LT(stairs.truth.riser_m, 0.20);  // what the ordinary robot can climb
      if (family == "spiral_left") {
        EXPECT_GT(stairs.turn_per_step_rad, 0.0);
      }
      if (family == "spiral_right") {
        EXPECT_LT(stairs.turn_per_step_rad, 0.0);
      }
    }
  });
}

TEST(FamilyTest, WalksOverGroundUpOrDownAsItsNameSays) {
  ForEachPlace([](const std::string& family, const Scene& scene) {
    const RayScene rays(scene);
    const Trajectory trajectory = PlanMotionIn(scene, rays, 1);
    EXPECT_GE(trajectory.duration_s(), 7.9);
    const double height = scene.mounting.body_height_m;
    EXPECT_NEAR(trajectory.PoseAt(0.0).translation().z(), height, 0.02);
    const double end = trajectory.PoseAt(trajectory.duration_s()).translation().z() - height;
    if (family == "drop" || family == "clutter") {
      EXPECT_NEAR(end, 0.0, 0.1);
    }
    if (family == "dogleg") {
      EXPECT_GT(end, 0.25);
    }
  });
}

TEST(FamilyTest, NothingStandsInTheRobotsWay) {
  ForEachPlace([](const std::string& family, const Scene& scene) {
    const RayScene rays(scene);
    const Trajectory trajectory = PlanMotionIn(scene, rays, 1);
    for (double t_s = 0.0; t_s < trajectory.duration_s(); t_s += 0.2) {
      const Eigen::Isometry3d here = trajectory.PoseAt(t_s), next = trajectory.PoseAt(t_s + 0.2);
      const Eigen::Vector3d way = next.translation() - here.translation();
      if (way.norm() < 0.01) continue;
      const auto hit = rays.First(here.translation(), way.normalized());
      EXPECT_TRUE(!hit || hit->distance > way.norm())
          << family << " at " << t_s
          << " s: " << (hit ? scene.surfaces[static_cast<std::size_t>(hit->surface)].name : "");
    }
  });
}

TEST(FamilyTest, CallsGroundLevelThatTheRobotCannotStepDownTo) {
  for (std::uint32_t seed = 1; seed <= kNumSeeds; ++seed) {
    const Scene scene = DrawPlace("drop", seed);
    const auto lower = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
                                    [](const Surface& s) { return s.name == "lower ground"; });
    ASSERT_NE(lower, scene.surfaces.end());
    EXPECT_EQ(lower->label, "level");
    EXPECT_LT(lower->plane_world.offset_m, -0.25);
  }
}

TEST(FamilyTest, CutsASpiralOutOfTheFloorThatItStandsOn) {
  for (const char* family : {"spiral_left", "spiral_right"}) {
    const Scene scene = DrawPlace(family, 3);
    const auto floor = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
                                    [](const Surface& s) { return s.name == "floor"; });
    ASSERT_NE(floor, scene.surfaces.end());
    ASSERT_FALSE(floor->holes_world.empty()) << family;
    const Ring& hole = floor->holes_world.front();
    // A ring sector of the outer radius, and the rest of the column.
    EXPECT_GT(SignedArea(hole, Eigen::Vector3d::UnitZ()), 1.0) << family;
  }
}

}  // namespace
}  // namespace terrace::synthetic
