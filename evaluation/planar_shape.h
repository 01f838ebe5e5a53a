// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/plane_rings.h"

namespace terrace {

/// A planar polygon with holes that answers questions about points near it.
class PlanarShape {
 public:
  PlanarShape(const Plane& plane, const Ring& outline, const std::vector<Ring>& holes);

  const Plane& plane() const { return plane_; }
  /// Is the point, projected on the plane, inside the outline and outside the holes?
  bool LiesOver(const Eigen::Vector3d& p) const;
  /// Angle of the two normals, sign ignored: 0 to pi / 2.
  double AngleTo(const Plane& other) const;
  /// Distance from the point, projected on the plane, to the nearest edge of outline or holes.
  double DistanceToEdge(const Eigen::Vector3d& p) const;
  double BoxArea() const { return box_.volume(); }  ///< of the bounding box [m^2]
  /// Calls `use` with the centre of each cell of a square grid whose centre lies inside the shape. The grid
  /// runs along AxesOf(normal), is centred in the shape's bounding box there, and has that many whole cells
  /// as fit it best: so no centre of a rectangle's cells lies on its edge, where rounding would decide.
  void ForEachCell(double cell_m, const std::function<void(const Eigen::Vector3d&)>& use) const;

 private:
  Eigen::Vector2d InPlane(const Eigen::Vector3d& p) const { return {axes_.x.dot(p), axes_.y.dot(p)}; }
  bool Contains(const Eigen::Vector2d& q) const;

  Plane plane_;
  PlaneAxes axes_;
  std::vector<Ring2> rings_;  ///< outline first
  Eigen::AlignedBox2d box_;
};

/// The ring after a motion of its frame.
Ring Moved(const Eigen::Isometry3d& T_to_from, const Ring& ring);
Plane Moved(const Eigen::Isometry3d& T_to_from, const Plane& plane);

}  // namespace terrace
