// SPDX-License-Identifier: BSD-3-Clause
#include "test/evaluation/small_world.h"

namespace terrace {
namespace {

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();
constexpr double kCell_m = 0.04;

}  // namespace

TruePolygon Rectangle(int id, const std::string& label, const Eigen::Vector3d& corner,
                      const Eigen::Vector3d& axis_x, const Eigen::Vector3d& axis_y, int nx, int ny) {
  TruePolygon polygon;
  polygon.id = id;
  polygon.name = label + " " + std::to_string(id);
  polygon.label = label;
  polygon.plane_world.normal = axis_x.cross(axis_y);
  polygon.plane_world.offset_m = polygon.plane_world.normal.dot(corner);
  const Eigen::Vector3d along_x = nx * kCell_m * axis_x;
  const Eigen::Vector3d along_y = ny * kCell_m * axis_y;
  polygon.outline_world = {corner, corner + along_x, corner + along_x + along_y, corner + along_y};
  polygon.area_m2 = nx * ny * kCell_m * kCell_m;
  polygon.observed.axis_x = axis_x;
  polygon.observed.axis_y = axis_y;
  polygon.observed.origin_m = {axis_x.dot(corner), axis_y.dot(corner)};
  polygon.observed.cell_m = kCell_m;
  polygon.observed.nx = nx;
  polygon.observed.ny = ny;
  polygon.observed.seen.assign(static_cast<std::size_t>(nx * ny), 1);
  return polygon;
}

TrueScene SmallWorld() {
  TrueScene scene;
  scene.polygons.push_back(Rectangle(1, "walkway", {0, 0, 0}, kX, kY, 100, 50));
  scene.polygons.push_back(Rectangle(2, "wall", {0, 2, 0}, kX, kZ, 100, 50));  // faces -y
  scene.polygons.push_back(Rectangle(3, "obstacle", {1, 0.5, 0.5}, kX, kY, 20, 10));
  TrueStaircase staircase;
  staircase.id = 1;
  staircase.num_risers = 11;
  staircase.num_treads = 10;
  staircase.riser_m = 0.16;
  staircase.tread_m = 0.28;
  staircase.width_m = 1.4;
  staircase.foot_edge_world = {Eigen::Vector3d(4, 1.72, 0), Eigen::Vector3d(4, 0.32, 0)};
  staircase.head_edge_world = {Eigen::Vector3d(6.8, 1.72, 1.76), Eigen::Vector3d(6.8, 0.32, 1.76)};
  for (int step = 0; step < 10; ++step) {
    const Eigen::Vector3d foot(4 + 0.28 * step, 0.32, 0.16 * step);
    if (step % 2 == 0) {
      scene.polygons.push_back(Rectangle(11 + step / 2, "stair_riser", foot, kZ, kY, 4, 35));  // faces -x
      staircase.polygon_ids.push_back(11 + step / 2);
    }
    scene.polygons.push_back(Rectangle(21 + step, "stair_tread", foot + 0.16 * kZ, kX, kY, 7, 35));
    staircase.polygon_ids.push_back(21 + step);
  }
  scene.staircases.push_back(staircase);
  return scene;
}

TerrainMap MapOf(const TrueScene& scene) {
  TerrainMap map;
  for (const TruePolygon& polygon : scene.polygons) {
    TerrainRegion region;
    region.id = polygon.id;
    region.label = TerrainLabelFromName(polygon.label).value_or(TerrainLabel::kUnknown);
    region.plane_world = polygon.plane_world;
    region.outline_world = polygon.outline_world;
    region.holes_world = polygon.holes_world;
    region.area_m2 = polygon.area_m2;
    map.regions.push_back(std::make_shared<const TerrainRegion>(region));
  }
  for (const TrueStaircase& truth : scene.staircases) {
    Staircase staircase;
    staircase.id = truth.id;
    staircase.num_risers = truth.num_risers;
    staircase.num_treads = truth.num_treads;
    staircase.riser_m = truth.riser_m;
    staircase.tread_m = truth.tread_m;
    staircase.width_m = truth.width_m;
    staircase.foot_edge_world = truth.foot_edge_world;
    staircase.head_edge_world = truth.head_edge_world;
    staircase.direction_up_world = truth.direction_up_world;
    map.staircases.push_back(staircase);
  }
  return map;
}

TerrainMap WithRegion(const TerrainMap& map, std::int64_t id, void (*edit)(TerrainRegion&)) {
  TerrainMap changed = map;
  changed.regions.clear();
  for (const auto& region : map.regions) {
    if (region->id != id) {
      changed.regions.push_back(region);
    } else if (edit != nullptr) {
      TerrainRegion edited = *region;
      edit(edited);
      changed.regions.push_back(std::make_shared<const TerrainRegion>(edited));
    }
  }
  return changed;
}

TerrainMap Transformed(const Eigen::Isometry3d& T_new_old, const TerrainMap& map) {
  TerrainMap moved = map;
  moved.regions.clear();
  for (const auto& region : map.regions) {
    TerrainRegion edited = *region;
    edited.plane_world.normal = T_new_old.linear() * region->plane_world.normal;
    edited.plane_world.offset_m += edited.plane_world.normal.dot(T_new_old.translation());
    for (Eigen::Vector3d& p : edited.outline_world) p = T_new_old * p;
    moved.regions.push_back(std::make_shared<const TerrainRegion>(edited));
  }
  for (Staircase& staircase : moved.staircases) {
    for (auto* edge : {&staircase.foot_edge_world, &staircase.head_edge_world}) {
      for (Eigen::Vector3d& p : *edge) p = T_new_old * p;
    }
    staircase.direction_up_world = T_new_old.linear() * staircase.direction_up_world;
  }
  return moved;
}

}  // namespace terrace
