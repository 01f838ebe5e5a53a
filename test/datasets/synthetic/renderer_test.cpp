// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/renderer.h"

#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test/datasets/synthetic/small_scene.h"

namespace terrace::synthetic {
namespace {

Eigen::Isometry3d PoseOf(const Scene& scene, double x, double y, double yaw) {
  Eigen::Isometry3d T_world_body = Eigen::Isometry3d::Identity();
  T_world_body.translation() << x, y, scene.mounting.body_height_m;
  T_world_body.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T_world_body * scene.mounting.T_body_left();
}

float At(const Radiance& image, int u, int v) {
  return image.data[static_cast<std::size_t>(v * image.width + u)];
}

float Bilinear(const Radiance& image, double u, int v) {
  const int u0 = static_cast<int>(std::floor(u));
  const auto share = static_cast<float>(u - u0);
  return (1.0F - share) * At(image, u0, v) + share * At(image, u0 + 1, v);
}

TEST(RendererTest, WhatTheLeftCameraSeesLiesWhereItsDepthSaysInTheRightImage) {
  const Scene scene = SmallScene();
  Renderer renderer(scene, {16, 0});
  const Eigen::Isometry3d T_world_left = PoseOf(scene, 0.0, 0.0, 0.05);
  Eigen::Isometry3d T_world_right = T_world_left;
  T_world_right.translation() += scene.camera.baseline_m * T_world_left.linear().col(0);
  const Radiance left = renderer.Render([&](double) { return T_world_left; }, 0.0, 1);
  const Radiance right = renderer.Render([&](double) { return T_world_right; }, 0.0, 2);
  const TrueView truth = renderer.Look(T_world_left, 0.0);
  const TrueView truth_right = renderer.Look(T_world_right, 0.0);
  double sum = 0.0;
  double sum_shifted = 0.0;
  int count = 0;
  for (int v = 0; v < truth.height; ++v) {
    for (int u = 1; u + 1 < truth.width; ++u) {
      const auto i = static_cast<std::size_t>(v * truth.width + u);
      if (truth.surface[i] < 0) continue;
      const double ur = u - scene.camera.Disparity(truth.depth_m[i]);
      if (ur < 1.0 || ur > truth.width - 3.0) continue;
      // Away from edges, and not hidden in the right image.
      const auto j = static_cast<std::size_t>(v * truth.width + std::lround(ur));
      if (truth.surface[i - 1] != truth.surface[i] || truth.surface[i + 1] != truth.surface[i]) continue;
      if (truth_right.surface[j] != truth.surface[i] || truth_right.surface[j + 1] != truth.surface[i] ||
          truth_right.surface[j - 1] != truth.surface[i]) {
        continue;
      }
      EXPECT_NEAR(truth_right.depth_m[j], truth.depth_m[i], 0.02 * truth.depth_m[i]);
      sum += std::abs(Bilinear(right, ur, v) - At(left, u, v)) / At(left, u, v);
      sum_shifted += std::abs(Bilinear(right, ur - 1.0, v) - At(left, u, v)) / At(left, u, v);
      ++count;
    }
  }
  ASSERT_GT(count, 8000);
  // Interpolation blurs the right image: what is left of the difference is far below that of a pixel's shift.
  EXPECT_LT(sum / count, 0.05);
  EXPECT_LT(sum, 0.5 * sum_shifted);
}

TEST(RendererTest, TrueDepthsTriangulateOntoTheTruePlanes) {
  const Scene scene = SmallScene();
  Renderer renderer(scene, {1, 1});
  const Eigen::Isometry3d T_world_left = PoseOf(scene, 0.2, 0.1, -0.1);
  const TrueView truth = renderer.Look(T_world_left, 0.0);
  int seen = 0;
  for (int v = 0; v < truth.height; ++v) {
    for (int u = 0; u < truth.width; ++u) {
      const auto i = static_cast<std::size_t>(v * truth.width + u);
      if (truth.surface[i] < 0) continue;
      const Eigen::Vector3d p_left = scene.camera.Triangulate(u, v, scene.camera.Disparity(truth.depth_m[i]));
      const Surface& surface = scene.surfaces[static_cast<std::size_t>(truth.surface[i])];
      EXPECT_NEAR(surface.plane_world.SignedDistance(T_world_left * p_left), 0.0, 5e-6);
      ++seen;
    }
  }
  EXPECT_GT(seen, 10000);
}

/// Where a dark run of pixels ends and a white one begins. Pixels average the light over their square: what
/// is missing to white, summed up, is the length of the dark.
double DarkLength(std::vector<double>::const_iterator begin, std::vector<double>::const_iterator end,
                  double white) {
  double length = 0.0;
  for (auto pixel = begin; pixel != end; ++pixel) length += 1.0 - *pixel / white;
  return length;
}

/// A bright square in front of nothing, faced squarely by a camera at the origin that looks along +y.
const std::array<Eigen::Vector3d, 4> kSquare{
    Eigen::Vector3d(-0.313, 1.5, -0.257), Eigen::Vector3d(0.361, 1.5, -0.257),
    Eigen::Vector3d(0.361, 1.5, 0.289), Eigen::Vector3d(-0.313, 1.5, 0.289)};
Scene SquareScene() {
  Scene scene;
  scene.camera = {200, 160, 150.0, 150.0, 99.5, 79.5, 0.12};
  scene.lighting.sky = 0.0;
  scene.lighting.ambient = 1.0;
  scene.materials = {{"white", Pattern::kPlain, 0.5, 0.0, 0.3, 0.0, 1}};
  SceneBuilder builder(scene);
  QuadSpec square;
  square.corners = kSquare;
  builder.AddQuad(square, 0);
  builder.Finish();
  return scene;
}

TEST(RendererTest, CornersOfAPlaneTriangulateWithinATenthOfAPixel) {
  const Scene scene = SquareScene();
  Renderer renderer(scene, {16, 0});
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
  T_world_left.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  Eigen::Isometry3d T_world_right = T_world_left;
  T_world_right.translation().x() += scene.camera.baseline_m;
  struct Box {
    double left, right, top, bottom;
  };
  const auto measure = [&](const Eigen::Isometry3d& T) {
    const Radiance image = renderer.Render([&](double) { return T; }, 0.0, 1);
    // Means over many rows and columns well inside the square.
    const auto column_mean = [&](int u) {
      double sum = 0.0;
      for (int v = 60; v < 100; ++v) sum += At(image, u, v);
      return sum / 40.0;
    };
    const auto row_mean = [&](int v) {
      double sum = 0.0;
      for (int u = 80; u < 110; ++u) sum += At(image, u, v);
      return sum / 30.0;
    };
    std::vector<double> along, down;
    for (int u = 0; u < image.width; ++u) along.push_back(column_mean(u));
    for (int v = 0; v < image.height; ++v) down.push_back(row_mean(v));
    const double white = column_mean(90);
    Box box{};
    box.left = DarkLength(along.begin(), along.begin() + 90, white) - 0.5;
    box.right = image.width - 0.5 - DarkLength(along.begin() + 90, along.end(), white);
    box.top = DarkLength(down.begin(), down.begin() + 80, white) - 0.5;
    box.bottom = image.height - 0.5 - DarkLength(down.begin() + 80, down.end(), white);
    return box;
  };
  const Box in_left = measure(T_world_left);
  const Box in_right = measure(T_world_right);
  constexpr double kTenthPixel = 0.1;
  for (const Eigen::Vector3d& corner : kSquare) {
    const Eigen::Vector3d p_left = T_world_left.inverse() * corner;
    const Eigen::Vector2d expected = scene.camera.Project(p_left);
    const double u = corner.x() < 0.0 ? in_left.left : in_left.right;
    const double ur = corner.x() < 0.0 ? in_right.left : in_right.right;
    const double v = corner.z() > 0.0 ? in_left.top : in_left.bottom;
    EXPECT_NEAR(u, expected.x(), kTenthPixel);
    EXPECT_NEAR(v, expected.y(), kTenthPixel);
    EXPECT_NEAR(u - ur, scene.camera.Disparity(p_left.z()), kTenthPixel);
    const Eigen::Vector2d back = scene.camera.Project(scene.camera.Triangulate(u, v, u - ur));
    EXPECT_LT((back - expected).norm(), kTenthPixel * std::sqrt(2.0));
  }
}

TEST(RendererTest, AnyNumberOfThreadsGivesTheSameImage) {
  const Scene scene = SmallScene();
  const Eigen::Isometry3d pose = PoseOf(scene, 0.0, 0.0, 0.0);
  Renderer one(scene, {4, 1});
  Renderer three(scene, {4, 3});
  const auto pose_at = [&](double) { return pose; };
  EXPECT_EQ(one.Render(pose_at, 0.0, 5).data, three.Render(pose_at, 0.0, 5).data);
  EXPECT_EQ(one.Look(pose, 0.0).surface, three.Look(pose, 0.0).surface);
}

TEST(RendererTest, MovementDuringTheExposureBlursTheEdgesAcrossIt) {
  Scene scene = SquareScene();
  scene.photometry.exposure_s = 0.04;
  Renderer renderer(scene, {16, 0});
  // Turns to the right about the vertical: 9 px in the exposure.
  const auto turning = [](double t) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    pose.linear() = Eigen::AngleAxisd(-1.5 * t, Eigen::Vector3d::UnitZ()).toRotationMatrix() * pose.linear();
    return pose;
  };
  const Radiance image = renderer.Render(turning, 0.0, 3);
  const float white = At(image, 95, 80);
  const auto is_between = [&](float value) { return value > 0.02F * white && value < 0.98F * white; };
  int along = 0;
  for (int u = 0; u < 95; ++u) along += is_between(At(image, u, 80)) ? 1 : 0;
  int down = 0;
  for (int v = 0; v < 80; ++v) down += is_between(At(image, 95, v)) ? 1 : 0;
  EXPECT_NEAR(along, 9, 1);
  EXPECT_LE(down, 2);
}

TEST(RendererTest, AMirrorShowsWhatStandsBehindItUpsideDown) {
  // A floor that reflects all, a white wall ahead whose lower half is dark: the floor's far part shows the
  // dark.
  Scene scene;
  scene.camera = {64, 96, 80.0, 80.0, 31.5, 47.5, 0.12};
  scene.lighting.sky = 0.0;
  scene.lighting.ambient = 1.0;
  scene.lighting.occlusion_reach_m = 0.01;
  scene.materials = {{"mirror", Pattern::kPlain, 0.02, 0.0, 0.3, 1.0, 1},
                     {"dark", Pattern::kPlain, 0.1, 0.0, 0.3, 0.0, 1},
                     {"white", Pattern::kPlain, 0.8, 0.0, 0.3, 0.0, 1}};
  SceneBuilder builder(scene);
  builder.AddFloor({"floor", {0.0, -5.0}, {3.0, 5.0}, 0.0, "walkway", false}, 0);
  WallSpec low{"low", {3.0, -5.0}, {3.0, 5.0}, 0.0, 1.0, 0.0, "wall", {}};
  WallSpec high{"high", {3.0, -5.0}, {3.0, 5.0}, 1.0, 4.0, 0.0, "wall", {}};
  builder.AddWall(low, 1);
  builder.AddWall(high, 2);
  builder.Finish();
  Renderer renderer(scene, {4, 1});
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // looks along +x
  pose.translation() << 0.5, 0.0, 1.0;
  const Radiance image = renderer.Render([&](double) { return pose; }, 0.0, 1);
  // The eye is 1 m above the floor, the border of the wall at 1 m: its image lies 1 m below the floor, 2.5 m
  // away, 2 m below the eye.
  const double border = scene.camera.cy + scene.camera.fy * 2.0 / 2.5;
  const int border_row = static_cast<int>(std::lround(border));
  ASSERT_LT(border_row, image.height + 40);
  const double floor_edge = scene.camera.cy + scene.camera.fy * 1.0 / 2.5;
  EXPECT_NEAR(At(image, 32, static_cast<int>(floor_edge) + 5), 0.1 + 0.02, 0.02);
}

}  // namespace
}  // namespace terrace::synthetic
