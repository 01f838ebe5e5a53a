// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/synthetic/hash.h"
#include "datasets/synthetic/scene.h"
#include "datasets/synthetic/scene_builder.h"

namespace terrace::synthetic {

/// Indices of materials.
struct PlaceMaterials {
  int ground, steps, risers, walls, more_walls, things;
};

/// A level rectangle.
struct Area {
  Eigen::Vector2d min;
  Eigen::Vector2d max;
};

/// A place that is being drawn. The robot starts near the origin and walks towards x. What every family has
/// in common is drawn here: materials, camera, gait, light, rooms and the things that lie about.
class Place {
 public:
  Place(const std::string& family, std::uint32_t seed);
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

  // Arguments of a call are evaluated in any order: only one of them may draw, or they stand in braces.
  double Draw(double low, double high) { return random_.Uniform(low, high); }
  int DrawCount(int low, int high);  ///< both included
  bool Chance(double share) { return random_.Uniform() < share; }
  double DrawSign() { return Chance(0.5) ? 1.0 : -1.0; }

  SceneBuilder& build() { return builder_; }
  const PlaceMaterials& material() const { return material_; }

  void Floor(const std::string& name, const Area& area, double z_m, const std::string& label = "walkway");
  /// A wall that is seen from the left of the way from `from` to `to`.
  void Wall(const std::string& name, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double z_m,
            double height_m);
  /// Four walls seen from inside.
  void Room(const Area& area, double z_m, double height_m);
  /// Up to `most` boxes on the floor, inside the area, clear of each other and of the line of the walk by
  /// `clear_m`. Their tops are walkway where they are low and large enough to step on.
  void Things(const Area& area, double z_m, int least, int most, double clear_m);

  /// Keeps things out of a circle.
  void Reserve(const Eigen::Vector2d& middle, double radius_m);

  /// Ceiling lamps over these points.
  void Lamps(const std::vector<Eigen::Vector3d>& centers);
  void Sun();

  /// The first point is moved a little aside, so that the approach is never straight.
  /// @param num_frames  that the robot walks, at 10 Hz
  void Walk(std::vector<Eigen::Vector2d> path, int num_frames = 80);

  Scene Finish();

 private:
  int AddMaterial(const std::string& name, const std::vector<Pattern>& patterns, double low_albedo,
                  double high_albedo);
  bool IsClear(const Eigen::Vector2d& at, double radius_m, double clear_m) const;

  Random random_;
  Scene scene_;
  SceneBuilder builder_;
  PlaceMaterials material_{};
  std::vector<Eigen::Vector3d> things_;  ///< x, y, radius
};

/// Draws what the family is about into a place; see family.cpp.
void DrawStairsUp(Place& place);
void DrawStairsUpFree(Place& place);
void DrawStairsDown(Place& place);
void DrawStairsOpen(Place& place);
void DrawSpiral(Place& place, double side);  ///< 1: turns left going up, -1: right
void DrawDogleg(Place& place);
void DrawDrop(Place& place);
void DrawRamp(Place& place);
void DrawKerb(Place& place);
void DrawClutter(Place& place);

}  // namespace terrace::synthetic
