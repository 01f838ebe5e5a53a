// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/polygon_revision.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace terrace {
namespace {

/// Covariance of tilt about x, tilt about y and offset at the centroid, axes of AxesOf(normal). With the
/// plane as z = z0 + a x + b y, the tilt about x is b and the tilt about y is -a.
Eigen::Matrix3d PlaneCovariance(const Surface& surface, const Eigen::Vector3d& centroid_world) {
  const PlaneAxes axes = AxesOf(surface.plane_world.normal);
  PlaneMoments about;
  about.Add(surface.moments, surface.origin_world - centroid_world);
  const Eigen::Vector3d to_tilt_x = axes.y, to_tilt_y = -axes.x;
  Eigen::Matrix3d information;
  information << to_tilt_x.dot(about.sum_outer * to_tilt_x), to_tilt_x.dot(about.sum_outer * to_tilt_y),
      to_tilt_x.dot(about.sum),  //
      to_tilt_y.dot(about.sum_outer * to_tilt_x), to_tilt_y.dot(about.sum_outer * to_tilt_y),
      to_tilt_y.dot(about.sum),  //
      to_tilt_x.dot(about.sum), to_tilt_y.dot(about.sum), about.weight;
  Eigen::Matrix3d covariance = information.inverse();
  // What more points do not cure.
  const double systematic = kSystematic_m * kSystematic_m;
  const Eigen::Matrix3d spread = about.Covariance();
  covariance(0, 0) += systematic / std::max(1e-8, axes.y.dot(spread * axes.y));
  covariance(1, 1) += systematic / std::max(1e-8, axes.x.dot(spread * axes.x));
  covariance(2, 2) += systematic;
  return covariance;
}

/// From the axes of the outline to the plane as it lies now, along the normal that the axes belong to.
Eigen::Vector3d Lift(const Surface& surface, const Eigen::Vector2d& p) {
  const Eigen::Vector3d at = surface.origin_world + p.x() * surface.axes.x + p.y() * surface.axes.y;
  const Plane& plane = surface.plane_world;
  return at - plane.SignedDistance(at) / plane.normal.dot(surface.anchor_normal) * surface.anchor_normal;
}

Ring Lift(const Surface& surface, const Ring2& ring) {
  Ring lifted;
  lifted.reserve(ring.size());  // polygons are kept
  for (const Eigen::Vector2d& p : ring) lifted.push_back(Lift(surface, p));
  return lifted;
}

}  // namespace

Polygon MakePolygon(PolygonId id, const Surface& surface, const TracedPiece& piece, Timestamp t_capture) {
  Polygon polygon;
  polygon.id = id;
  polygon.revision = 1;
  polygon.plane_world = surface.plane_world;
  polygon.outline_world = Lift(surface, piece.outline);
  polygon.holes_world.reserve(piece.holes.size());
  for (const Ring2& hole : piece.holes) polygon.holes_world.push_back(Lift(surface, hole));
  // Traced in the axes, from which the plane may have turned a little since.
  polygon.area_m2 = piece.area_m2 / surface.plane_world.normal.dot(surface.anchor_normal);
  polygon.centroid_world = Lift(surface, piece.centroid);
  polygon.seen_past = piece.seen_past;
  polygon.support = piece.support;
  polygon.rms_m = std::sqrt(surface.moments.MeanSquaredDistance(
      {surface.plane_world.normal,
       surface.plane_world.offset_m - surface.plane_world.normal.dot(surface.origin_world)}));
  polygon.noise_m = surface.noise_m;
  polygon.plane_covariance = PlaneCovariance(surface, polygon.centroid_world);
  polygon.num_observations = 1;
  polygon.first_seen = polygon.last_seen = t_capture;
  return polygon;
}

bool HasChanged(const Polygon& before, const Polygon& now, double min_change_m) {
  double perimeter = 0.0;
  const Ring& ring = now.outline_world;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    // The plane as it was and as it is, at the corners.
    if (std::abs(before.plane_world.SignedDistance(ring[i])) > min_change_m) return true;
    perimeter += (ring[(i + 1) % ring.size()] - ring[i]).norm();
  }
  if (before.holes_world.size() != now.holes_world.size()) return true;
  return std::abs(before.area_m2 - now.area_m2) > min_change_m * perimeter;
}

}  // namespace terrace
