// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace terrace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The plane normal . p = offset_m; the unit normal points to the side that was seen.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0.0;

  double SignedDistance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset_m; }
  Eigen::Vector3d Project(const Eigen::Vector3d& p) const { return p - SignedDistance(p) * normal; }
};

/// Two axes in a plane with x cross y = normal, so that a ring which is counter-clockwise in (x, y) is
/// counter-clockwise seen from where the normal points. A pure function of the normal: the same bits every
/// time.
struct PlaneAxes {
  Eigen::Vector3d x;
  Eigen::Vector3d y;
};
PlaneAxes AxesOf(const Eigen::Vector3d& normal);

/// The unit quaternion of a rotation, on a grid fine enough to mean nothing (6e-14) and coarse enough that a
/// rotation matrix made from it gives the same quaternion again, bit for bit. Rotations that travel as
/// quaternions in messages and logs are brought onto it wherever they enter, so that a recording and the log
/// made from it agree exactly.
Eigen::Quaterniond CanonicalQuaternion(const Eigen::Matrix3d& rotation);
/// The same pose with its rotation on that grid.
Eigen::Isometry3d CanonicalPose(const Eigen::Isometry3d& pose);

/// A simple closed ring; the first vertex is not repeated.
using Ring = std::vector<Eigen::Vector3d>;

/// Area enclosed by a planar ring [m^2], positive when it runs counter-clockwise seen from where the normal
/// points.
double SignedArea(const Ring& ring, const Eigen::Vector3d& normal);

}  // namespace terrace
