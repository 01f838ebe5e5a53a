// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/synthesis.h"

#include <gtest/gtest.h>

#include "core/file_bytes.h"
#include "datasets/ground_truth.h"
#include "datasets/image_file.h"
#include "datasets/sequence.h"
#include "test/datasets/synthetic/small_scene.h"

namespace terrace::synthetic {
namespace {

namespace fs = std::filesystem;

fs::path Fresh(const std::string& name) {
  const fs::path folder = fs::path(testing::TempDir()) / ("synthesis_" + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

SynthesisConfig SmallConfig(int threads) {
  SynthesisConfig config;
  config.renderer.num_threads = threads;
  config.max_frames = 12;
  return config;
}

std::map<std::string, std::vector<std::uint8_t>> AllBytes(const fs::path& folder) {
  std::map<std::string, std::vector<std::uint8_t>> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder)] = ReadFileBytes(entry.path());
  }
  return files;
}

TEST(SynthesisTest, TheSameSeedGivesTheSameBytesWithAnyNumberOfThreads) {
  const fs::path a = Fresh("a");
  const fs::path b = Fresh("b");
  Synthesize(SmallScene(), SmallConfig(1), a, {});
  Synthesize(SmallScene(), SmallConfig(3), b, {});
  const auto files = AllBytes(a);
  EXPECT_GT(files.size(), 30u);
  EXPECT_TRUE(files == AllBytes(b));
  SynthesisConfig other = SmallConfig(2);
  other.seed = 2;
  const fs::path c = Fresh("c");
  Synthesize(SmallScene(), other, c, {});
  EXPECT_NE(files.begin()->second.empty(), true);
  EXPECT_FALSE(files == AllBytes(c));
}

TEST(SynthesisTest, TheReadersReadWhatItWrites) {
  const fs::path folder = Fresh("read");
  const Scene scene = SmallScene();
  const SynthesisSummary summary = Synthesize(scene, SmallConfig(2), folder, {});
  EXPECT_EQ(summary.num_frames, 12);

  const auto sequence = OpenSequence(folder);
  EXPECT_EQ(sequence->info().num_frames, 12);
  EXPECT_TRUE(sequence->info().calibration.rectified());
  EXPECT_NEAR(sequence->info().calibration.baseline_m(), scene.camera.baseline_m, 1e-9);
  EXPECT_TRUE(sequence->info().has_imu);
  EXPECT_TRUE(sequence->info().has_attitude);
  EXPECT_TRUE(sequence->info().has_legs);
  int frames = 0;
  while (const auto frame = sequence->Next()) {
    EXPECT_EQ(frame->pair.problem, "");
    EXPECT_EQ(frame->pair.left.width, scene.camera.width);
    EXPECT_GE(frame->samples.imu.size(), frames > 0 ? 13u : 1u);
    ++frames;
  }
  EXPECT_EQ(frames, 12);

  const TrueTrajectory poses = LoadTrueTrajectory(folder);
  EXPECT_GE(poses.poses.size(), 12u);
  const TrueScene truth = LoadTrueScene(folder);
  ASSERT_EQ(truth.polygons.size(), scene.surfaces.size());
  EXPECT_EQ(truth.staircases.size(), 1u);
  const TruePolygon& floor = truth.polygons[0];
  EXPECT_EQ(floor.name, "floor");
  EXPECT_EQ(floor.holes_world.size(), 2u);  // under the box and under the stairs
  ASSERT_GT(floor.observed.nx, 0);
  int seen = 0;
  for (const std::uint8_t cell : floor.observed.seen) seen += cell;
  EXPECT_GT(seen, 500);
  EXPECT_NEAR(floor.observed.Centre(0, 0, floor.plane_world).z(), 0.0, 1e-9);
}

TEST(SynthesisTest, DepthAndLabelImagesAgreeWithTheTruePlanes) {
  const fs::path folder = Fresh("images");
  const Scene scene = SmallScene();
  SynthesisConfig config = SmallConfig(2);
  config.rate_hz = 10.0;  // frames that fall on states of the body
  Synthesize(scene, config, folder, {});
  const TrueScene truth = LoadTrueScene(folder);
  const auto depths = TrueDepthImages(folder);
  const auto labels = TrueLabelImages(folder);
  ASSERT_EQ(depths.size(), 2u);
  ASSERT_EQ(labels.size(), 2u);
  const TrueTrajectory poses = LoadTrueTrajectory(folder);
  for (const auto& [t, path] : depths) {
    const Gray16Image depth = ReadGray16Png(path);
    const Gray16Image label = ReadGray16Png(labels.at(t));
    const auto pose = std::find_if(poses.poses.begin(), poses.poses.end(),
                                   [&image_time = t](const TimedPose& p) { return std::abs((p.t - image_time).count()) < 10'000; });
    ASSERT_NE(pose, poses.poses.end());
    const Eigen::Isometry3d T_world_left = poses.frame == TruthFrame::kBody
                                               ? pose->T_world_frame * scene.mounting.T_body_left()
                                               : pose->T_world_frame;
    for (std::size_t i = 0; i < depth.data.size(); i += 7) {
      if (label.data[i] == 0) continue;
      const double z = depth.data[i] * 1e-3;
      const auto u = static_cast<double>(i % static_cast<std::size_t>(depth.width));
      const auto v = static_cast<double>(i / static_cast<std::size_t>(depth.width));
      const Eigen::Vector3d p = T_world_left * scene.camera.Triangulate(u, v, scene.camera.Disparity(z));
      // Half a millimetre of rounding along the ray, which is longer than z at the image's corner.
      EXPECT_NEAR(truth.polygons[label.data[i] - 1u].plane_world.SignedDistance(p), 0.0, 1e-3);
    }
  }
}

TEST(SynthesisTest, WhatMovesIsNotInTheMapAndItsPlaceBecomesFree) {
  Scene scene = SmallScene();
  scene.surfaces.clear();
  scene.staircases.clear();
  SceneBuilder builder(scene);
  builder.AddFloor({"floor", {-1.0, -4.0}, {5.0, 4.0}, 0.0, "walkway", false}, 0);
  BoxSpec box;
  box.base_center = {1.5, 0.0, 0.0};
  builder.AddMovingBox(box, {{0.3, {0, 0, 0}}, {0.6, {0, 5, 0}}}, 1);
  builder.Finish();
  const fs::path folder = Fresh("moving");
  Synthesize(scene, SmallConfig(2), folder, {});
  const TrueScene truth = LoadTrueScene(folder);
  ASSERT_EQ(truth.polygons.size(), 1u);
  EXPECT_TRUE(truth.polygons[0].holes_world.empty());
  ASSERT_EQ(truth.objects.size(), 1u);
  const int mesh = truth.objects[0].mesh_id.value();
  const auto labels = TrueLabelImages(folder);
  const auto count = [&](const fs::path& path) {
    const Gray16Image image = ReadGray16Png(path);
    return std::count(image.data.begin(), image.data.end(), mesh);
  };
  EXPECT_GT(count(labels.begin()->second), 100);
  EXPECT_EQ(count(labels.rbegin()->second), 0);
}

TEST(SynthesisTest, ConfigurationProblemsAreListed) {
  SynthesisConfig config;
  EXPECT_TRUE(config.Problems().empty());
  config.gain = 0.0;
  config.rate_hz = -1.0;
  config.renderer.samples = 3;
  EXPECT_EQ(config.Problems().size(), 3u);
}

}  // namespace
}  // namespace terrace::synthetic
