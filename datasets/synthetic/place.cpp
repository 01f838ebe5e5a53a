// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/place.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/angles.h"
#include "core/plane_rings.h"

namespace terrace::synthetic {
namespace {

constexpr double kPlaceRate_hz = 10.0;
/// What the ordinary robot climbs, and stands on (DESIGN.md, "Labels"); boxes between the two heights would
/// be disputed, so there are none.
constexpr double kSurelyStep_m = 0.17;
constexpr double kSurelyTooHigh_m = 0.24;
constexpr double kStandingRoom_m = 0.5;
/// Lamps shine as one of these strengths would over the ground 2.6 m below.
constexpr double kLampHeight_m = 2.6;

/// A seed that depends on the name alone, not on what other families there are (FNV-1a).
std::uint32_t HashOf(const std::string& name) {
  std::uint32_t hash = 2166136261U;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

/// Distance from a point to the nearest piece of a path.
double DistanceToPath(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& path) {
  double least_m = 1e9;
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    least_m = std::min(least_m, (NearestOnSegment(path[i], path[i + 1], p) - p).norm());
  return least_m;
}

}  // namespace

Place::Place(const std::string& family, std::uint32_t seed)
    : random_(Hash(HashOf(family), seed)), builder_(scene_) {
  scene_.name = family + "_" + std::to_string(seed);
  scene_.description = "A place of the family " + family + ", drawn by seed " + std::to_string(seed) + ".";
  scene_.seed = seed;
  scene_.rate_hz = kPlaceRate_hz;
  scene_.mounting.pitch_down_rad = Radians(Draw(12.0, 32.0));
  scene_.mounting.body_height_m = Draw(0.28, 0.52);
  Photometry& photometry = scene_.photometry;
  photometry.gain_right = Draw(0.96, 1.05);
  photometry.exposure_s = Draw(0.002, 0.007);
  photometry.full_well = Draw(9000.0, 25000.0);
  MotionPlan& motion = scene_.motion;
  motion.speed_mps = Draw(0.38, 0.55);
  motion.bounce = Draw(0.6, 1.2);
  motion.gaze_rad = Draw(0.03, 0.12);
  material_.ground = AddMaterial(
      "ground", {Pattern::kConcrete, Pattern::kTiles, Pattern::kWood, Pattern::kNoise, Pattern::kBrick}, 0.3,
      0.55);
  material_.steps =
      AddMaterial("steps", {Pattern::kConcrete, Pattern::kNoise, Pattern::kWood, Pattern::kTiles}, 0.35, 0.6);
  material_.risers = AddMaterial("risers", {Pattern::kConcrete, Pattern::kNoise, Pattern::kBrick}, 0.25, 0.5);
  material_.walls = AddMaterial("walls", {Pattern::kPlain, Pattern::kConcrete, Pattern::kBrick}, 0.4, 0.7);
  material_.more_walls = AddMaterial("more walls", {Pattern::kPosters, Pattern::kPlain}, 0.4, 0.65);
  material_.things = AddMaterial("things", {Pattern::kWood, Pattern::kChecker, Pattern::kNoise}, 0.3, 0.6);
}

int Place::DrawCount(int low, int high) {
  return low + std::min(static_cast<int>(Draw(0.0, 1.0) * (high - low + 1)), high - low);
}

int Place::AddMaterial(const std::string& name, const std::vector<Pattern>& patterns, double low_albedo,
                       double high_albedo) {
  constexpr double kScale_m[kNumPatterns] = {0.3, 0.3, 0.3, 0.35, 0.13, 0.075, 0.12, 0.9, 0.05};
  Material material;
  material.name = name;
  material.pattern = patterns[static_cast<std::size_t>(DrawCount(0, static_cast<int>(patterns.size()) - 1))];
  material.albedo = Draw(low_albedo, high_albedo);
  material.contrast = Draw(0.5, 1.4);
  material.scale_m = Draw(0.8, 1.3) * kScale_m[static_cast<int>(material.pattern)];
  material.seed = static_cast<std::uint32_t>(DrawCount(1, 9999));
  scene_.materials.push_back(material);
  return static_cast<int>(scene_.materials.size()) - 1;
}

void Place::Floor(const std::string& name, const Area& area, double z_m, const std::string& label) {
  builder_.AddFloor({name, area.min, area.max, z_m, label, false}, material_.ground);
}

void Place::Wall(const std::string& name, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double z_m,
                 double height_m) {
  WallSpec wall;
  wall.name = name;
  wall.from = from;
  wall.to = to;
  wall.z_m = z_m;
  wall.height_m = height_m;
  builder_.AddWall(wall, Chance(0.5) ? material_.walls : material_.more_walls);
}

void Place::Room(const Area& area, double z_m, double height_m) {
  const Eigen::Vector2d a = area.min, b(area.max.x(), area.min.y()), c = area.max, d(area.min.x(), c.y());
  Wall("wall right", a, b, z_m, height_m);
  Wall("wall ahead", b, c, z_m, height_m);
  Wall("wall left", c, d, z_m, height_m);
  Wall("wall behind", d, a, z_m, height_m);
}

bool Place::IsClear(const Eigen::Vector2d& at, double radius_m, double clear_m) const {
  if (DistanceToPath(at, scene_.motion.path) < radius_m + clear_m) return false;
  return std::none_of(things_.begin(), things_.end(), [&](const Eigen::Vector3d& thing) {
    return (thing.head<2>() - at).norm() < thing.z() + radius_m + 0.05;
  });
}

void Place::Things(const Area& area, double z_m, int least, int most, double clear_m) {
  constexpr int kTries = 30;  // for each; a crowded area gets fewer
  const int count = DrawCount(least, most);
  for (int i = 0; i < count; ++i) {
    BoxSpec box;
    box.size_m = {Draw(0.15, 0.7), Draw(0.15, 0.6),
                  Chance(0.35) ? Draw(0.08, kSurelyStep_m) : Draw(kSurelyTooHigh_m, 1.3)};
    box.yaw_rad = Draw(-0.8, 0.8);
    box.name = "box " + std::to_string(things_.size() + 1);
    const double radius_m = 0.5 * box.size_m.head<2>().norm();
    const bool step = box.size_m.z() <= kSurelyStep_m && box.size_m.head<2>().minCoeff() >= kStandingRoom_m;
    if (step) box.top_label = "walkway";
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const Eigen::Vector2d low = area.min.array() + radius_m + 0.02,
                            high = area.max.array() - radius_m - 0.02;
      if ((high - low).minCoeff() <= 0.0) break;
      const Eigen::Vector2d at{Draw(low.x(), high.x()), Draw(low.y(), high.y())};
      if (!IsClear(at, radius_m, clear_m)) continue;
      box.base_center = {at.x(), at.y(), z_m};
      builder_.AddBox(box, material_.things);
      things_.push_back({at.x(), at.y(), radius_m});
      break;
    }
  }
}

void Place::Lamps(const std::vector<Eigen::Vector3d>& centers) {
  scene_.lighting.ambient = Draw(0.2, 0.4);
  for (const Eigen::Vector3d& center : centers) {
    Lamp lamp;
    lamp.center = center + Eigen::Vector3d{Draw(-0.4, 0.4), Draw(-0.2, 0.2), kLampHeight_m};
    lamp.size_m = {Draw(0.3, 1.3), Draw(0.2, 0.6)};
    lamp.strength = Draw(1.8, 3.4);
    scene_.lighting.lamps.push_back(lamp);
  }
}

void Place::Sun() {
  scene_.lighting.ambient = Draw(0.3, 0.5);
  Lamp sun;
  sun.distant = true;
  const double azimuth = Draw(0.0, 2.0 * std::numbers::pi);
  sun.direction = {std::cos(azimuth), std::sin(azimuth), -Draw(0.7, 1.8)};
  sun.softness_rad = Draw(0.005, 0.15);
  sun.strength = Draw(0.3, 0.8);
  scene_.lighting.lamps.push_back(sun);
}

void Place::Walk(std::vector<Eigen::Vector2d> path, int num_frames) {
  path.front() += Eigen::Vector2d{Draw(-0.2, 0.0), Draw(-0.25, 0.25)};
  scene_.motion.path = std::move(path);
  // The last frame is taken at the end; a hair more keeps rounding from losing it.
  scene_.motion.duration_s = (num_frames - 1) / kPlaceRate_hz + 1e-3;
}

void Place::Reserve(const Eigen::Vector2d& middle, double radius_m) {
  things_.push_back({middle.x(), middle.y(), radius_m});
}

Scene Place::Finish() {
  builder_.Finish();
  return std::move(scene_);
}

}  // namespace terrace::synthetic
