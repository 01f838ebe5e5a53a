// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "labeling/plan_geometry.h"
#include "polygonization/polygon.h"

namespace terrace {

/// How a piece leans, judged by gravity.
enum class Lean {
  kSupport,  ///< level or sloped, seen from above
  kSteep,    ///< too steep to walk on, not yet upright
  kUpright,
  kFacingDown,
};

/// Where a face begins and ends, for one column of it.
struct FaceColumn {
  double along_m = 0.0;   ///< position along RegionShape::face_axis
  double bottom_m = 0.0;  ///< level frame
  double top_m = 0.0;
};

/// What the rules need to know about one polygon. All of it in the *level frame*: the world turned by the
/// smallest rotation that brings up to +z. Made once for each revision of a polygon.
struct RegionShape {
  PolygonPtr polygon;
  Lean lean = Lean::kSteep;
  Plane plane;
  double slope_rad = 0.0;        ///< from level, 0..pi
  double slope_sigma_rad = 0.0;  ///< from the plane's covariance
  double area_m2 = 0.0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3d bounds;

  /// Seen from above, simplified: the outline, then the holes. Of an upright face no more than a line.
  std::vector<PlanRing> plan;
  PlanRectangle rectangle;  ///< of the outline in the plan
  /// Edge of the largest square in the plan, up to what was asked for. Supports only.
  double largest_square_m = 0.0;

  /// Horizontal unit vector along an upright face; its front is on the right when looking along it.
  Eigen::Vector2d face_axis = Eigen::Vector2d::Zero();
  std::vector<FaceColumn> columns;  ///< upright faces only, ascending

  /// From the middle foot to the middle top of the columns: not moved by a spike of the outline.
  Interval face_heights;
  /// So high reach a fifth of the columns: of a riser and the walls beside it in one plane, the walls.
  double high_top_m = 0.0;

  PolygonId id() const { return polygon->id; }
  /// Tells the wall from the riser where both are one upright face.
  bool ReachesUpperHalf(const FaceColumn& column) const {
    return column.top_m >= 0.5 * (bounds.min().z() + high_top_m);
  }
  Interval heights() const { return {bounds.min().z(), bounds.max().z()}; }
  /// Height of a support's plane above a point of the plan.
  double HeightAt(const Eigen::Vector2d& p) const {
    return (plane.offset_m - plane.normal.head<2>().dot(p)) / plane.normal.z();
  }
  /// Distance in the plan from p to the area (0 inside it), and the point of the area that is nearest.
  double PlanDistance(const Eigen::Vector2d& p, Eigen::Vector2d* nearest = nullptr) const;
  /// The point of an upright face at a column and a height.
  Eigen::Vector3d FacePoint(double along_m, double z) const;
  /// Horizontal unit vector to the side from which an upright face was seen.
  Eigen::Vector2d front() const { return {face_axis.y(), -face_axis.x()}; }
};
using RegionShapePtr = std::shared_ptr<const RegionShape>;

/// Limits between the ways to lean, and what is worth measuring.
struct RegionShapeLimits {
  double max_support_slope_rad = 0.0;
  double min_upright_slope_rad = 0.0;
  double enough_square_m = 0.0;
};

RegionShapePtr MakeRegionShape(const PolygonPtr& polygon, const Eigen::Matrix3d& R_level_world,
                               const RegionShapeLimits& limits);

}  // namespace terrace
