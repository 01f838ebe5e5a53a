// SPDX-License-Identifier: BSD-3-Clause
#include "client/occupied_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "client/ot_cells.h"
#include "client/spatial_order.h"

namespace terrace {
namespace {

// What lies so near to a region is its own roughness, seen through the noise of stereo, which grows with
// distance.
constexpr double kLeastRoughness_m = 0.03;
constexpr double kRoughnessSigmas = 3.0;

/// Where along a + t * along, t in [0, 1], the segment is nearest to the box. The slope of the squared
/// distance grows with t, on a straight line between the planes of the box.
double NearestParameter(const Eigen::Vector3d& a, const Eigen::Vector3d& along,
                        const Eigen::AlignedBox3d& box) {
  const auto slope = [&](double t) {
    const Eigen::Vector3d p = a + t * along;
    return along.dot(p - p.cwiseMax(box.min()).cwiseMin(box.max()));
  };
  std::array<double, 8> parameters{0.0, 1.0};
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const double plane = side == 0 ? box.min()[axis] : box.max()[axis];
      const double t = along[axis] == 0.0 ? 0.0 : (plane - a[axis]) / along[axis];
      parameters[static_cast<std::size_t>(2 + 2 * axis + side)] = std::clamp(t, 0.0, 1.0);
    }
  }
  std::sort(parameters.begin(), parameters.end());
  double before = slope(0.0);
  if (before >= 0.0) return 0.0;
  for (std::size_t i = 1; i < parameters.size(); ++i) {
    const double here = slope(parameters[i]);
    if (here >= 0.0)
      return parameters[i - 1] + (parameters[i] - parameters[i - 1]) * before / (before - here);
    before = here;
  }
  return 1.0;
}

/// The least move along an axis that takes the whole segment out of the box.
OccupiedSpace::Nearest WayOut(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::AlignedBox3d& box) {
  OccupiedSpace::Nearest out{-std::numeric_limits<double>::infinity(), Eigen::Vector3d::UnitZ()};
  for (int axis = 0; axis < 3; ++axis) {
    const double up_m = box.max()[axis] - std::min(a[axis], b[axis]);
    const double down_m = std::max(a[axis], b[axis]) - box.min()[axis];
    if (-up_m > out.distance_m) out = {-up_m, Eigen::Vector3d::Unit(axis)};
    if (-down_m > out.distance_m) out = {-down_m, -Eigen::Vector3d::Unit(axis)};
  }
  return out;
}

}  // namespace

bool IsOnARegion(const Eigen::Vector3d& p_world, double distance_m, const TerrainQuery& query) {
  bool is_on = false;
  constexpr double kMostRoughness_m = 0.15;
  const double farthest_m = distance_m + kMostRoughness_m;
  query.tree().ForEach(
      [&](const Eigen::AlignedBox3d& box) {
        return !is_on && box.squaredExteriorDistance(p_world) <= farthest_m * farthest_m;
      },
      [&](std::size_t i) {
        const TerrainQuery::Entry& entry = query.entries()[query.order()[i]];
        if (entry.region->predicted()) return;
        const RegionShape& shape = *entry.shape;
        const double near_m = distance_m + std::clamp(kRoughnessSigmas * entry.region->rms_m,
                                                      kLeastRoughness_m, kMostRoughness_m);
        if (std::abs(shape.normal_world().dot(p_world - shape.centroid_world())) > near_m) return;
        const Eigen::Vector2d flat = shape.ToPlane(p_world);
        is_on =
            is_on || shape.polygon().Contains(flat) || shape.polygon().NearestEdge(flat).distance_m <= near_m;
      });
  return is_on;
}

OccupiedSpace::OccupiedSpace(const octree_v1_t& message, const TerrainQuery& query)
    : box_world_(Eigen::Vector3d(message.box_min), Eigen::Vector3d(message.box_max)) {
  if (!box_world_.min().allFinite() || !box_world_.max().allFinite() || box_world_.isEmpty())
    throw std::runtime_error("octree: says no box");
  if (message.encoding != octree_v1_t::OCTOMAP_OT) throw std::runtime_error("octree: is no .ot");
  if (message.map_id != query.map().map_id) throw std::runtime_error("octree: is of another map");
  const OccupiedCells octree = ReadOtCells(message.data);
  for (const OccupiedCell& cell : octree.cells) {
    const double edge_m = cell.num_leaves * octree.leaf_m;
    const Eigen::Vector3d low = octree.leaf_m * cell.corner.cast<double>();
    const Eigen::AlignedBox3d cube(low, low + Eigen::Vector3d::Constant(edge_m));
    if (!IsOnARegion(cube.center(), 0.5 * edge_m, query)) cubes_world_.push_back(cube);
  }
  Sort();
}

OccupiedSpace::OccupiedSpace(const Eigen::AlignedBox3d& box_world,
                             std::vector<Eigen::AlignedBox3d> cubes_world)
    : box_world_(box_world), cubes_world_(std::move(cubes_world)) {
  Sort();
}

void OccupiedSpace::Sort() {
  std::vector<Eigen::AlignedBox3d> ordered;
  ordered.reserve(cubes_world_.size());
  for (const std::uint32_t i : SpatialOrder(cubes_world_)) ordered.push_back(cubes_world_[i]);
  cubes_world_ = std::move(ordered);
  tree_ = BoxTree<3>(cubes_world_);
}

std::optional<OccupiedSpace::Nearest> OccupiedSpace::NearestTo(const Eigen::Vector3d& a_world,
                                                               const Eigen::Vector3d& b_world,
                                                               double farthest_m) const {
  Eigen::AlignedBox3d axis(a_world);
  axis.extend(b_world);
  const Eigen::Vector3d along = b_world - a_world;
  std::optional<Nearest> nearest;
  tree_.FindNearest(
      [&](const Eigen::AlignedBox3d& box) {
        const double squared = box.squaredExteriorDistance(axis);
        const double bound = std::max(0.0, nearest ? nearest->distance_m : farthest_m);
        return squared <= bound * bound ? squared : std::numeric_limits<double>::infinity();
      },
      [&](std::size_t i) {
        const Eigen::AlignedBox3d& cube = cubes_world_[i];
        const Eigen::Vector3d p = a_world + NearestParameter(a_world, along, cube) * along;
        const Eigen::Vector3d away = p - p.cwiseMax(cube.min()).cwiseMin(cube.max());
        const double distance_m = away.norm();
        const Nearest here =
            distance_m > 0.0 ? Nearest{distance_m, away / distance_m} : WayOut(a_world, b_world, cube);
        if (here.distance_m <= farthest_m && (!nearest || here.distance_m < nearest->distance_m))
          nearest = here;
        return std::numeric_limits<double>::infinity();  // `nearest` bounds the search
      });
  return nearest;
}

}  // namespace terrace
