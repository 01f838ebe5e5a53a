// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
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

/// True when the sequence comes with true poses.
bool HasTrueTrajectory(const std::filesystem::path& sequence);

/// The true poses of a sequence: the `groundtruth_tum.txt` of an EuRoC folder (raw left camera, at the times
/// of the frames), else its body states, or the `poses.txt` of a KITTI folder (rectified left camera), else
/// what the camera's own tracking said (`zed_tracking.tum`, the same camera), or what an LCM log holds. Throws FileError.
TrueTrajectory LoadTrueTrajectory(const std::filesystem::path& sequence);

/// Cells of a true polygon that some frame saw within 5 m; none (nx = 0) when no frame did.
/// Cell (i, j) has its centre at Centre(i, j) in the plane of the polygon; edge cells may have it outside the
/// rings.
struct ObservedCells {
  Eigen::Vector3d axis_x = Eigen::Vector3d::UnitX();
  Eigen::Vector3d axis_y = Eigen::Vector3d::UnitY();
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();
  double cell_m = 0.04;
  int nx = 0;
  int ny = 0;
  std::vector<std::uint8_t> seen;  ///< seen[i * ny + j], 0 or 1

  Eigen::Vector3d Centre(int i, int j, const Plane& plane) const {
    return axis_x * (origin_m.x() + cell_m * (i + 0.5)) + axis_y * (origin_m.y() + cell_m * (j + 0.5)) +
           plane.normal * plane.offset_m;
  }
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
  double riser_m = 0.0;                 ///< mean
  double tread_m = 0.0;                 ///< mean
  std::vector<double> riser_heights_m;  ///< lowest first
  std::vector<double> tread_depths_m;   ///< lowest first
  double width_m = 0.0;
  Eigen::Vector3d direction_up_world = Eigen::Vector3d::UnitX();  ///< unit, z = 0; of a spiral: at its foot
  /// Left and right end of the foot and head edges, looking up the stairs.
  std::array<Eigen::Vector3d, 2> foot_edge_world{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::array<Eigen::Vector3d, 2> head_edge_world{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::vector<int> polygon_ids;
};

/// A thing made of polygons, of a mesh, or of both.
struct TrueObject {
  std::string name;
  std::string label;
  std::optional<int> mesh_id;  ///< what the label images hold on its mesh
  std::vector<int> polygon_ids;
};

/// Everything true about a scene.
struct TrueScene {
  std::vector<TruePolygon> polygons;
  std::vector<TrueStaircase> staircases;
  std::vector<TrueObject> objects;
};

/// True when the sequence comes with a scene (`ground_truth.json`).
bool HasTrueScene(const std::filesystem::path& sequence);

/// Reads `ground_truth.json` and `observed_cells.npz` of a sequence folder. Throws FileError.
TrueScene LoadTrueScene(const std::filesystem::path& sequence);

/// The true images of a sequence by capture time: 16-bit z depth [mm] and 16-bit polygon or mesh ids of the
/// left camera, 0 = nothing. Empty when there are none.
std::map<Timestamp, std::filesystem::path> TrueDepthImages(const std::filesystem::path& sequence);
std::map<Timestamp, std::filesystem::path> TrueLabelImages(const std::filesystem::path& sequence);

}  // namespace terrace
