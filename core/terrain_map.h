// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry.h"
#include "core/pose_estimate.h"
#include "core/time.h"

namespace terrace {

/// What a planner may read a region as. The numbers are those of region_v1_t.
enum class TerrainLabel {
  kUnknown = 0,
  kWalkway = 1,
  kRamp = 2,
  kStairTread = 3,
  kStairRiser = 4,
  kWall = 5,
  kObstacle = 6,
  kLevel = 7,
};
inline constexpr int kNumTerrainLabels = 8;
const char* Name(TerrainLabel label);  ///< "walkway", "stair_tread", ...
std::optional<TerrainLabel> TerrainLabelFromName(const std::string& name);

/// What lies beyond one edge of a region's outline. The numbers are those of region_v1_t.
enum class EdgeKind : std::int8_t {
  kLimitOfView = 0,  ///< nothing known beyond
  kDrop = 1,
  kRise = 2,   ///< an upright face stands on it
  kJoins = 3,  ///< another region continues here
};
inline constexpr int kNumEdgeKinds = 4;
const char* Name(EdgeKind kind);  ///< "limit", "drop", "rise", "joins"
std::optional<EdgeKind> EdgeKindFromName(const std::string& name);

/// One edge of a region's outline or hole, from the vertex that it belongs to to the next.
struct RegionEdge {
  EdgeKind kind = EdgeKind::kLimitOfView;
  std::optional<double>
      step_m;  ///< height of what lies beyond over the edge, negative: lower; none: not known
  std::optional<double> sigma_m;  ///< of step_m; none: not known

  friend bool operator==(const RegionEdge&, const RegionEdge&) = default;
};

/// How a region is known. The numbers are those of region_v1_t.
enum class RegionSource : std::int8_t {
  kSeen = 0,
  kPredicted = 1,  ///< not seen, inferred: a missing step of a staircase
  kFeet = 2,       ///< felt by the robot's feet
};
inline constexpr int kNumRegionSources = 3;

/// One planar piece of terrain. Immutable once it is in a map; a change makes a new revision.
struct TerrainRegion {
  std::int64_t id = 0;  ///< positive; stable while tracked; one that has gone comes back only where it lay
  int revision = 0;     ///< greater whenever anything below has changed
  TerrainLabel label = TerrainLabel::kUnknown;
  double confidence = 0.0;  ///< of the label, 0..1
  std::string why;          ///< what keeps the region undecided; empty: nothing does
  Plane plane_world;
  /// Tilt about x, tilt about y [rad], offset along the normal [m], about `centroid_world` with the axes of
  /// AxesOf(normal).
  Eigen::Matrix3d plane_covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d centroid_world = Eigen::Vector3d::Zero();  ///< in the plane
  double rms_m = 0.0;
  double area_m2 = 0.0;           ///< outline less holes
  Ring outline_world;             ///< counter-clockwise seen from where the normal points; simple
  std::vector<Ring> holes_world;  ///< clockwise, inside the outline; simple
  /// The edge that starts at each vertex, outline first, then the holes; empty: all kLimitOfView.
  std::vector<RegionEdge> edges;
  double support = 0.0;  ///< share of the area with observed points, 0..1
  RegionSource source = RegionSource::kSeen;
  int num_observations = 0;
  Timestamp first_seen;
  Timestamp last_seen;
  std::optional<std::int64_t> staircase_id;
  std::optional<int> step_index;  ///< riser 1 is the lowest, tread 1 lies above riser 1

  bool predicted() const { return source == RegionSource::kPredicted; }
};

/// A flight of steps; straight, or turning about an axis.
struct Staircase {
  std::int64_t id = 0;  ///< positive
  int num_risers = 0;
  int num_treads = 0;
  double riser_m = 0.0;  ///< mean height
  double riser_sigma_m = 0.0;
  double tread_m = 0.0;  ///< mean depth
  double tread_sigma_m = 0.0;
  double width_m = 0.0;
  /// Left and right end of the foot and head edges, looking up the stairs.
  std::array<Eigen::Vector3d, 2> foot_edge_world{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::array<Eigen::Vector3d, 2> head_edge_world{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  Eigen::Vector3d direction_up_world = Eigen::Vector3d::UnitX();  ///< unit, z = 0
  double turn_per_step_rad = 0.0;  ///< 0: straight; positive turns left going up
  double pitch_rad = 0.0;
  double confidence = 0.0;
  std::vector<std::int64_t> region_ids;  ///< ascending
  Timestamp last_seen;

  Eigen::Vector3d base_world() const { return 0.5 * (foot_edge_world[0] + foot_edge_world[1]); }
};

/// The labelled map after one frame. Shared and never edited; unchanged regions are shared between maps.
struct TerrainMap {
  Timestamp t_capture;                                             ///< newest image included
  std::int64_t seq = 0;                                            ///< +1 whenever something below changes
  std::int64_t map_id = 1;                                         ///< new value whenever the map is cleared
  int epoch = 0;                                                   ///< jumps of the world so far
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();  ///< of that image
  Matrix6d covariance = Matrix6d::Zero();                          ///< of T_world_left, as in PoseEstimate
  /// Where the camera sits on the robot; none: no body is known.
  std::optional<Eigen::Isometry3d> T_body_left;
  Gravity gravity;
  std::vector<std::shared_ptr<const TerrainRegion>> regions;  ///< ascending by id
  std::vector<Staircase> staircases;                          ///< ascending by id
};
using TerrainMapPtr = std::shared_ptr<const TerrainMap>;

}  // namespace terrace
