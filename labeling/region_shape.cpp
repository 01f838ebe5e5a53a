// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/region_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace terrace {
namespace {

/// Outlines follow cells and have many short edges; this much is left out of them.
constexpr double kSimplifyTolerance = 0.025;
constexpr double kColumnWidth = 0.1;
constexpr int kMaxColumns = 128;

PlanRing PlanOf(const Ring& ring_world, const Eigen::Matrix3d& R_level_world) {
  PlanRing plan;
  plan.reserve(ring_world.size());
  for (const Eigen::Vector3d& p : ring_world) plan.push_back((R_level_world * p).head<2>());
  return plan;
}

/// Splits an upright face into columns and finds the lowest and the highest point of each.
std::vector<FaceColumn> ColumnsOf(const Ring& ring_world, const Eigen::Matrix3d& R_level_world,
                                  const Eigen::Vector2d& face_axis) {
  PlanRing profile;  // x along the face, y up
  profile.reserve(ring_world.size());
  for (const Eigen::Vector3d& p_world : ring_world) {
    const Eigen::Vector3d p = R_level_world * p_world;
    profile.emplace_back(face_axis.dot(p.head<2>()), p.z());
  }
  const Interval width = Extent(profile, Eigen::Vector2d::UnitX());
  const int num = std::clamp(static_cast<int>(std::lround(width.length() / kColumnWidth)), 1, kMaxColumns);
  const double step = width.length() / num;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<FaceColumn> columns(num, FaceColumn{0.0, kNone, -kNone});
  for (int c = 0; c < num; ++c) columns[c].along_m = width.low + (c + 0.5) * step;
  if (step <= 0.0) return {};
  for (std::size_t i = 0, j = profile.size() - 1; i < profile.size(); j = i++) {
    const Eigen::Vector2d& a = profile[j].x() < profile[i].x() ? profile[j] : profile[i];
    const Eigen::Vector2d& b = profile[j].x() < profile[i].x() ? profile[i] : profile[j];
    const int first = std::max(0, static_cast<int>(std::ceil((a.x() - width.low) / step - 0.5)));
    for (int c = first; c < num && columns[c].along_m <= b.x(); ++c) {
      const double run = b.x() - a.x();
      const double z = run > 0.0 ? a.y() + (b.y() - a.y()) * (columns[c].along_m - a.x()) / run : a.y();
      columns[c].bottom_m = std::min(columns[c].bottom_m, z);
      columns[c].top_m = std::max(columns[c].top_m, z);
    }
  }
  std::erase_if(columns, [](const FaceColumn& column) { return column.top_m < column.bottom_m; });
  return columns;
}

double HighTop(const std::vector<FaceColumn>& columns) {
  std::vector<double> tops;
  for (const FaceColumn& column : columns) tops.push_back(column.top_m);
  const auto high = tops.end() - static_cast<std::ptrdiff_t>((tops.size() + 4) / 5);
  std::nth_element(tops.begin(), high, tops.end());
  return *high;
}

Interval MiddleHeights(const std::vector<FaceColumn>& columns) {
  std::vector<double> bottoms, tops;
  for (const FaceColumn& column : columns) {
    bottoms.push_back(column.bottom_m);
    tops.push_back(column.top_m);
  }
  const auto middle = static_cast<std::ptrdiff_t>(columns.size() / 2);
  std::nth_element(bottoms.begin(), bottoms.begin() + middle, bottoms.end());
  std::nth_element(tops.begin(), tops.begin() + middle, tops.end());
  return {bottoms[middle], tops[middle]};
}

Lean LeanOf(double slope_rad, const RegionShapeLimits& limits) {
  if (slope_rad <= limits.max_support_slope_rad) return Lean::kSupport;
  if (slope_rad < limits.min_upright_slope_rad) return Lean::kSteep;
  if (slope_rad <= std::numbers::pi - limits.min_upright_slope_rad) return Lean::kUpright;
  return Lean::kFacingDown;
}

}  // namespace

double RegionShape::PlanDistance(const Eigen::Vector2d& p, Eigen::Vector2d* nearest) const {
  bool inside = Contains(plan.front(), p);
  const PlanRing* ring = &plan.front();
  for (std::size_t hole = 1; inside && hole < plan.size(); ++hole) {
    if (!Contains(plan[hole], p)) continue;
    inside = false;
    ring = &plan[hole];
  }
  if (inside) {
    if (nearest) *nearest = p;
    return 0.0;
  }
  const Eigen::Vector2d q = NearestOnRing(*ring, p);
  if (nearest) *nearest = q;
  return (q - p).norm();
}

Eigen::Vector3d RegionShape::FacePoint(double along_m, double z) const {
  // The face axis is horizontal and in the plane, so only the step across it has to be found.
  const Eigen::Vector2d normal = plane.normal.head<2>();
  const Eigen::Vector2d base = face_axis * along_m;
  const double across = (plane.offset_m - plane.normal.z() * z - normal.dot(base)) / normal.dot(front());
  const Eigen::Vector2d p = base + front() * across;
  return {p.x(), p.y(), z};
}

RegionShapePtr MakeRegionShape(const PolygonPtr& polygon, const Eigen::Matrix3d& R_level_world,
                               const RegionShapeLimits& limits) {
  auto shape = std::make_shared<RegionShape>();
  shape->polygon = polygon;
  shape->plane = {R_level_world * polygon->plane_world.normal, polygon->plane_world.offset_m};
  shape->centroid = R_level_world * polygon->centroid_world;
  shape->area_m2 = polygon->area_m2;
  shape->slope_rad = std::acos(std::clamp(shape->plane.normal.z(), -1.0, 1.0));
  shape->slope_sigma_rad =
      std::sqrt(std::max(0.0, std::max(polygon->plane_covariance(0, 0), polygon->plane_covariance(1, 1))));
  shape->lean = LeanOf(shape->slope_rad, limits);
  for (const Eigen::Vector3d& p : polygon->outline_world) shape->bounds.extend(R_level_world * p);

  shape->plan.push_back(SimplifyPlan(PlanOf(polygon->outline_world, R_level_world), kSimplifyTolerance));
  shape->rectangle = SmallestRectangle(shape->plan.front());
  if (shape->lean == Lean::kUpright) {
    shape->face_axis = Eigen::Vector2d(-shape->plane.normal.y(), shape->plane.normal.x()).normalized();
    shape->columns = ColumnsOf(polygon->outline_world, R_level_world, shape->face_axis);
    shape->face_heights = shape->columns.empty() ? shape->heights() : MiddleHeights(shape->columns);
    shape->high_top_m = shape->columns.empty() ? shape->heights().high : HighTop(shape->columns);
  }
  if (shape->lean == Lean::kSupport) {
    for (const Ring& hole : polygon->holes_world)
      shape->plan.push_back(SimplifyPlan(PlanOf(hole, R_level_world), kSimplifyTolerance));
    shape->largest_square_m = LargestSquare(shape->plan, shape->rectangle, limits.enough_square_m);
  }
  return shape;
}

}  // namespace terrace
