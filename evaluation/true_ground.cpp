// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/true_ground.h"

#include <cmath>

#include "evaluation/edge_errors.h"

namespace terrace {
namespace {

/// What is steeper than 60 deg is a face, not a place for a foot.
constexpr double kUprightNormalZ = 0.5;
/// How far beyond an edge the ground is asked for: past the rounding of what adjoins it.
constexpr double kBeyondEdge_m = 0.03;
/// Ground this much lower is a drop.
constexpr double kDrop_m = 0.05;
/// Ground at most this much higher goes on level.
constexpr double kLevel_m = 0.025;
/// A face rises at an edge when it is met this high above it, not farther away than that.
constexpr double kFaceAbove_m = 0.05;
constexpr double kFaceAway_m = 0.03;

Ring Flattened(const Ring& ring) {
  Ring flat = ring;
  for (Eigen::Vector3d& p : flat) p.z() = 0.0;
  return flat;
}

PlanarShape PlanOf(const TruePolygon& polygon) {
  std::vector<Ring> holes;
  for (const Ring& hole : polygon.holes_world) holes.push_back(Flattened(hole));
  return {{Eigen::Vector3d::UnitZ(), 0.0}, Flattened(polygon.outline_world), holes};
}

bool IsUpright(const Plane& plane) { return std::abs(plane.normal.z()) < kUprightNormalZ; }

}  // namespace

TrueGround::TrueGround(const TrueScene& scene) : shapes_(ShapesOf(scene, {})) {
  for (const TruePolygon& polygon : scene.polygons) {
    if (!IsUpright(polygon.plane_world)) supports_.push_back({polygon.plane_world, PlanOf(polygon)});
  }
}

double TrueGround::Support::HeightAt(const Eigen::Vector3d& p) const {
  return (plane.offset_m - plane.normal.x() * p.x() - plane.normal.y() * p.y()) / plane.normal.z();
}

bool TrueGround::Carries(const Eigen::Vector3d& p, double disc_m, double height_m) const {
  for (const Support& support : supports_) {
    if (std::abs(support.HeightAt(p) - p.z()) > height_m) continue;
    if (support.plan.LiesOver(p) || support.plan.DistanceToEdge(p) <= disc_m) return true;
  }
  return false;
}

std::optional<double> TrueGround::HighestBelow(const Eigen::Vector3d& p) const {
  std::optional<double> highest;
  for (const Support& support : supports_) {
    const double height = support.HeightAt(p);
    if (height > p.z() + kLevel_m || (highest && height <= *highest)) continue;
    if (support.plan.LiesOver(p)) highest = height;
  }
  return highest;
}

bool TrueGround::FaceRisesAt(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d above = p + kFaceAbove_m * Eigen::Vector3d::UnitZ();
  for (const TrueShape& face : shapes_) {
    if (!IsUpright(face.shape.plane())) continue;
    if (std::abs(face.shape.plane().SignedDistance(above)) > kFaceAway_m) continue;
    if (face.shape.LiesOver(above)) return true;
  }
  return false;
}

std::vector<DropSample> TrueGround::Drops() const {
  std::vector<DropSample> drops;
  for (const TrueShape& ground : shapes_) {
    if (!IsWalkable(ground.polygon->label) || ground.polygon->detail) continue;
    ForEachEdgeSample(ground, [&](const Eigen::Vector3d& p, const Eigen::Vector3d& inwards) {
      const Eigen::Vector3d outwards = -Eigen::Vector3d(inwards.x(), inwards.y(), 0.0).normalized();
      const std::optional<double> beyond = HighestBelow(p + kBeyondEdge_m * outwards);
      if (beyond && *beyond > p.z() - kDrop_m) return;
      if (!FaceRisesAt(p)) drops.push_back({p, outwards});
    });
  }
  return drops;
}

}  // namespace terrace
