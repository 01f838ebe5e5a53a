// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/terrain_map.h"
#include "labeling/terrain_labeler.h"
#include "polygonization/polygon.h"

namespace terrace {

/// A polygon with what it truly is.
struct KnownPiece {
  Ring outline;
  std::vector<Ring> holes;
  TerrainLabel label = TerrainLabel::kUnknown;
  int step_index = 0;  ///< 0: not part of a staircase
};

/// How polygons from a real sensor differ from true ones.
struct Noise {
  double offset_m = 0.0;  ///< standard deviation along the normal
  double tilt_rad = 0.0;  ///< standard deviation of each tilt of a piece half a metre wide
  double edge_m = 0.0;    ///< standard deviation of every vertex in the plane
};

/// A flight of steps to be built.
struct KnownFlight {
  Eigen::Vector3d foot = Eigen::Vector3d::Zero();  ///< middle of the foot edge
  double yaw_rad = 0.0;                            ///< direction up
  int num_risers = 6;
  double rise_m = 0.17;
  double run_m = 0.28;
  double width_m = 1.4;
  bool open_risers = false;
  double nosing_m = 0.0;
};

/// Builds worlds of planar pieces for tests of the labels.
class LabelScene {
 public:
  /// A horizontal rectangle seen from above, turned by yaw about its centre.
  void AddLevel(TerrainLabel label, const Eigen::Vector3d& center, double size_x, double size_y,
                double yaw_rad = 0.0);
  /// An upright rectangle whose foot runs from a to b, seen from the right when looking from a to b.
  void AddFace(TerrainLabel label, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double height_m,
               int step_index = 0);
  /// A box with four sides and a top.
  void AddBox(const Eigen::Vector3d& foot_center, double size_x, double size_y, double height_m,
              double yaw_rad = 0.0, TerrainLabel top = TerrainLabel::kObstacle);
  void AddFlight(const KnownFlight& flight);
  /// Steps about a vertical axis; riser 1 lies in the direction of x from it.
  void AddSpiral(const Eigen::Vector3d& axis_foot, double inner_radius_m, double outer_radius_m,
                 int num_risers, double rise_m, double turn_per_step_rad);
  void Add(KnownPiece piece) { pieces.push_back(std::move(piece)); }

  /// As the merger would give them; ids are 1, 2, ... in the order of the pieces.
  PolygonUpdate Update(const Noise& noise = {}, unsigned seed = 1) const;

  std::vector<KnownPiece> pieces;
};

/// Left camera 0.45 m above the ground at (x, y), z = ground, looking along yaw, 20 deg down.
PoseEstimate StandingAt(double x, double y, double ground_z = 0.0, double yaw_rad = 0.0);
Eigen::Isometry3d TestBodyLeft();
StereoCamera TestCamera();
Gravity TestGravity();

/// A labeler with default settings and the camera above.
TerrainLabeler MakeLabeler();

/// Labels the same polygons several times, so that staircases are confirmed.
TerrainMapPtr LabelOften(TerrainLabeler& labeler, const PolygonUpdate& update, const PoseEstimate& pose,
                         int times = 6);

/// The seen regions whose label is not the true one, a line each; empty when all are right.
std::string WrongLabels(const LabelScene& scene, const TerrainMap& map);

}  // namespace terrace
