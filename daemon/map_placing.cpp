// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/map_placing.h"

#include <sstream>

namespace terrace {
namespace {

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return cross;
}

/// Turns level axes, z up, into a frame in which up is `up`, by the least turn.
Eigen::Matrix3d FromLevel(const Eigen::Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up).toRotationMatrix();
}

double YawOf(const Eigen::Vector3d& ahead) { return std::atan2(ahead.y(), ahead.x()); }

/// What an error of the place, in the axes of the world, does to a plane: tilt about its two axes, and along
/// its normal at `p_world`.
Eigen::Matrix<double, 3, 6> EffectOnPlane(const Eigen::Vector3d& normal_world,
                                          const Eigen::Vector3d& p_world) {
  const PlaneAxes axes = AxesOf(normal_world);
  Eigen::Matrix<double, 3, 6> effect = Eigen::Matrix<double, 3, 6>::Zero();
  effect.block<1, 3>(0, 0) = axes.x.transpose();
  effect.block<1, 3>(1, 0) = axes.y.transpose();
  effect.block<1, 3>(2, 0) = p_world.cross(normal_world).transpose();
  effect.block<1, 3>(2, 3) = normal_world.transpose();
  return -effect;
}

/// A covariance of tilts about other axes of the same plane.
Eigen::Matrix3d TurnedTilts(const Eigen::Matrix3d& covariance, const PlaneAxes& from, const PlaneAxes& to) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << to.x.dot(from.x), to.x.dot(from.y), to.y.dot(from.x), to.y.dot(from.y);
  return turn * covariance * turn.transpose();
}

/// Of errors at a point, in the axes of the world, as errors at the world's origin.
Matrix6d AtOrigin(const Matrix6d& covariance, const Eigen::Vector3d& p_world) {
  Matrix6d transport = Matrix6d::Identity();
  transport.bottomLeftCorner<3, 3>() = Cross(p_world);
  return transport * covariance * transport.transpose();
}

}  // namespace

std::optional<BodyInMap> BodyInMapFrom(const std::string& text) {
  std::istringstream in(text);
  BodyInMap body;
  double yaw_deg = 0.0;
  if (!(in >> body.p_map.x() >> body.p_map.y() >> body.p_map.z() >> yaw_deg)) return std::nullopt;
  std::string more;
  if (in >> more || !body.p_map.allFinite() || !std::isfinite(yaw_deg)) return std::nullopt;
  body.yaw_rad = yaw_deg * M_PI / 180.0;
  return body;
}

MapPlace PlaceOf(const BodyInMap& body_in_map, const Eigen::Isometry3d& T_world_body,
                 const Gravity& gravity_world, const Gravity& gravity_map) {
  const Eigen::Matrix3d R_world_level = FromLevel(gravity_world.up_world());
  const Eigen::Matrix3d R_map_level = FromLevel(gravity_map.up_world());
  const double yaw_level = YawOf(R_world_level.transpose() * T_world_body.linear().col(0));
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(body_in_map.yaw_rad - yaw_level, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  MapPlace place;
  place.T_map_world.linear() = R_map_level * turn * R_world_level.transpose();
  const Eigen::Vector3d& p_world = T_world_body.translation();
  place.T_map_world.translation() = body_in_map.p_map - place.T_map_world.linear() * p_world;
  // Errors at the body, in the axes of the world, seen from the world's origin.
  // No sigma at all is what a map has that does not know: up is never known better than this.
  constexpr double kLeastTilt_rad = 0.2 * M_PI / 180.0;
  const double tilt_variance = gravity_world.sigma_rad * gravity_world.sigma_rad +
                               gravity_map.sigma_rad * gravity_map.sigma_rad +
                               kLeastTilt_rad * kLeastTilt_rad;
  Matrix6d at_body = Matrix6d::Zero();
  at_body.topLeftCorner<3, 3>() =
      R_world_level *
      Eigen::Vector3d(tilt_variance, tilt_variance, body_in_map.sigma_yaw_rad * body_in_map.sigma_yaw_rad)
          .asDiagonal() *
      R_world_level.transpose();
  at_body.bottomRightCorner<3, 3>() =
      body_in_map.sigma_p_m * body_in_map.sigma_p_m * Eigen::Matrix3d::Identity();
  place.covariance = AtOrigin(at_body, p_world);
  return place;
}

MapPlace PlaceOf(const CameraInMap& camera_in_map, const Eigen::Isometry3d& T_world_left) {
  MapPlace place;
  place.T_map_world = camera_in_map.T_map_left * T_world_left.inverse();
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_world_left.linear();
  place.covariance = AtOrigin(turn * camera_in_map.covariance * turn.transpose(), T_world_left.translation());
  return place;
}

bool IsDecided(const TerrainRegion& region) {
  return !region.predicted() && region.label != TerrainLabel::kUnknown;
}

TerrainRegion Placed(const TerrainRegion& region_map, const MapPlace& place) {
  const Eigen::Isometry3d T_world_map = place.T_map_world.inverse();
  const Eigen::Matrix3d& R = T_world_map.linear();
  TerrainRegion region = region_map;
  region.centroid_world = T_world_map * region_map.plane_world.Project(region_map.centroid_world);
  region.plane_world.normal = (R * region_map.plane_world.normal).normalized();
  region.plane_world.offset_m = region.plane_world.normal.dot(region.centroid_world);
  const auto move = [&](Ring* ring) {
    for (Eigen::Vector3d& p : *ring) p = region.plane_world.Project(T_world_map * p);
  };
  move(&region.outline_world);
  for (Ring& hole : region.holes_world) move(&hole);
  // Zeros are what a map has that came from a file without covariances: they stay unknown.
  if (region_map.plane_covariance.isZero(0.0)) return region;
  const PlaneAxes before = AxesOf(region_map.plane_world.normal);
  const PlaneAxes turned{R * before.x, R * before.y};
  const auto effect = EffectOnPlane(region.plane_world.normal, region.centroid_world);
  region.plane_covariance =
      TurnedTilts(region_map.plane_covariance, turned, AxesOf(region.plane_world.normal)) +
      effect * place.covariance * effect.transpose();
  return region;
}

Staircase Placed(const Staircase& staircase_map, const MapPlace& place) {
  const Eigen::Isometry3d T_world_map = place.T_map_world.inverse();
  Staircase staircase = staircase_map;
  for (Eigen::Vector3d& p : staircase.foot_edge_world) p = T_world_map * p;
  for (Eigen::Vector3d& p : staircase.head_edge_world) p = T_world_map * p;
  staircase.direction_up_world = T_world_map.linear() * staircase_map.direction_up_world;
  staircase.direction_up_world.z() = 0.0;
  staircase.direction_up_world.normalize();
  return staircase;
}

}  // namespace terrace
