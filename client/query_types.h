// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/terrain_map.h"

namespace terrace {

/// A set of labels, to ask for.
class LabelSet {
 public:
  constexpr LabelSet() = default;  ///< none
  constexpr LabelSet(std::initializer_list<TerrainLabel> labels) {
    for (const TerrainLabel label : labels) bits_ |= 1u << static_cast<unsigned>(label);
  }
  constexpr bool Has(TerrainLabel label) const { return (bits_ >> static_cast<unsigned>(label)) & 1u; }

 private:
  std::uint32_t bits_ = 0;
};
/// What feet may stand on.
inline constexpr LabelSet kWalkableLabels{TerrainLabel::kWalkway, TerrainLabel::kRamp,
                                          TerrainLabel::kStairTread};
inline constexpr LabelSet kAllLabels{
    TerrainLabel::kUnknown,    TerrainLabel::kWalkway, TerrainLabel::kRamp,     TerrainLabel::kStairTread,
    TerrainLabel::kStairRiser, TerrainLabel::kWall,    TerrainLabel::kObstacle, TerrainLabel::kLevel};

/// One point of the ground and what is known about it. World frame, SI.
struct Support {
  Eigen::Vector3d point_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::UnitZ();
  double sigma_height_m = 0.0;  ///< of the point's height along z, by the plane's covariance; NaN: not known
  /// To the region's nearest edge, of whatever kind, along its plane; and what is there.
  double edge_distance_m = std::numeric_limits<double>::infinity();
  RegionEdge edge;
  TerrainLabel label = TerrainLabel::kUnknown;
  double confidence = 0.0;  ///< of the label
  double age_s = 0.0;       ///< of the region's newest sight, at the map's newest image
  RegionSource source = RegionSource::kSeen;
  std::int64_t region_id = 0;
};

/// What a foot needs of the ground that it is set on.
struct FootSpec {
  double radius_m = 0.03;      ///< of the sole; all of it stands on one region
  double clear_drop_m = 0.02;  ///< from the sole to an edge over a drop; besides the radius
  double clear_rise_m = 0.01;  ///< from the sole to an edge below an upright face; besides the radius
  double max_slope_rad = 30.0 * M_PI / 180.0;  ///< between the region's normal and up, by the map's gravity
  double min_confidence = 0.5;                 ///< of the region's label
  double max_age_s = std::numeric_limits<double>::infinity();
  bool allow_predicted = false;  ///< also on what was inferred and never seen
  LabelSet labels = kWalkableLabels;
};

/// A grid of heights, axes along the world's: cell (i, j) has its middle at `first_xy + cell_m * (i, j)`.
struct HeightGridSpec {
  Eigen::Vector2d first_xy = Eigen::Vector2d::Zero();  ///< middle of cell (0, 0) [m]
  double cell_m = 0.015;
  int num_x = 100;
  int num_y = 100;
  double z_min = -std::numeric_limits<double>::infinity();
  double z_max = std::numeric_limits<double>::infinity();
  LabelSet labels = kAllLabels;
};

struct HeightCell {
  static constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();
  float height_m = kNotKnown;  ///< along z; NaN: nothing is known here
  float sigma_m = kNotKnown;
  float age_s = kNotKnown;
  TerrainLabel label = TerrainLabel::kUnknown;  ///< of a known cell: seen and not decided
  bool predicted = false;
  std::int64_t region_id = 0;  ///< 0: nothing is known here

  bool known() const { return region_id != 0; }
};

/// What is known of the space that a capsule takes up.
enum class Occupancy {
  /// It touches neither face nor leaf of the octree, and lies over ground that was seen. Only what the octree
  /// was asked about can be free; what hangs there and was never in view is not known to it either.
  kFree,
  kOccupied,  ///< it touches a face, or a leaf of the octree that lies on none
  kUnknown,   ///< nobody has asked the octree, or it lies behind a face, or over what nobody has seen
};

/// How far a capsule is from all that is known.
struct Clearance {
  /// From the capsule's surface to the nearest face or leaf; negative: by how much it must be moved to be
  /// clear of that; infinite: there is none.
  double distance_m = std::numeric_limits<double>::infinity();
  /// Unit, world: the way in which a move takes the capsule away from that; zero: there is none.
  Eigen::Vector3d gradient_world = Eigen::Vector3d::Zero();
  std::int64_t region_id = 0;  ///< of the nearest face; 0: a leaf is nearer, or there is none
  Occupancy occupancy = Occupancy::kUnknown;
};

struct HeightGrid {
  HeightGridSpec spec;
  std::vector<HeightCell> cells;  ///< num_x * num_y, j runs faster

  const HeightCell& at(int i, int j) const {
    return cells[static_cast<std::size_t>(i) * static_cast<std::size_t>(spec.num_y) +
                 static_cast<std::size_t>(j)];
  }
};

}  // namespace terrace
