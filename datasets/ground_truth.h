// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/time.h"

namespace terrace {

/// A true pose of the camera or of the body.
struct TimedPose {
  Timestamp t;
  Eigen::Isometry3d T_world_frame = Eigen::Isometry3d::Identity();
};

/// Which frame the true poses are of.
enum class TruthFrame { kRectifiedLeft, kRawLeft, kBody };

struct TrueTrajectory {
  TruthFrame frame = TruthFrame::kRawLeft;
  std::vector<TimedPose> poses;  ///< ascending in time
};

/// Cells of a true polygon that some frame saw within 5 m.
/// Cell (i, j) has its centre at axis_x * (origin.x + cell_m * (i + 0.5)) + axis_y * (origin.y + ...) +
/// normal * offset.
struct ObservedCells {
  Eigen::Vector3d axis_x = Eigen::Vector3d::UnitX();
  Eigen::Vector3d axis_y = Eigen::Vector3d::UnitY();
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();
  double cell_m = 0.04;
  int nx = 0;
  int ny = 0;
  std::vector<std::uint8_t> seen;  ///< seen[i * ny + j]
};

/// One true plane. Labels are those of TerrainLabel by name, or "other".
struct TruePolygon {
  int id = 0;
  std::string name;
  std::string label;
  Plane plane_world;
  Ring outline_world;
  std::vector<Ring> holes_world;
  double area_m2 = 0.0;
  std::optional<int> staircase_id;
  std::optional<int> step_index;
  bool detail = false;  ///< small trim that a mapper need not find
  ObservedCells observed;
};

struct TrueStaircase {
  int id = 0;
  int num_risers = 0;
  int num_treads = 0;
  double riser_m = 0.0;
  double tread_m = 0.0;
  double width_m = 0.0;
  Eigen::Vector3d direction_world = Eigen::Vector3d::UnitX();
  Eigen::Vector3d base_world = Eigen::Vector3d::Zero();
  std::vector<int> polygon_ids;
};

/// Everything true about a scene.
struct TrueScene {
  std::vector<TruePolygon> polygons;
  std::vector<TrueStaircase> staircases;
};

}  // namespace terrace
