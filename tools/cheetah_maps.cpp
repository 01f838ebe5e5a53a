// SPDX-License-Identifier: BSD-3-Clause
#include "tools/cheetah_maps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {
namespace {

constexpr int kCells = 100;
constexpr int kRobotCell = 50;
constexpr double kCell_m = 0.015;

bool MayStand(const TerrainQuery& query, const HeightCell& cell, const Eigen::Vector3d& p_world,
              const FootSpec& foot) {
  const TerrainQuery::Entry* const entry = query.Find(cell.region_id);
  if (entry == nullptr || !query.Fits(*entry, foot)) return false;
  const EdgeMargins margins{foot.radius_m, foot.radius_m + foot.clear_drop_m,
                            foot.radius_m + foot.clear_rise_m};
  return entry->shape->Inset(margins)->Contains(entry->shape->ToPlane(p_world));
}

void SetRobot(const Eigen::Vector3d& body_world, double ground_z_world, CheetahMaps* maps) {
  maps->heights.robot_loc[0] = body_world.x();
  maps->heights.robot_loc[1] = body_world.y();
  maps->heights.robot_loc[2] = body_world.z() - ground_z_world;
}

}  // namespace

CheetahMaps CheetahMapsOf(const TerrainQuery& query, const Eigen::Isometry3d& T_world_body,
                          double ground_z_world, const FootSpec& foot) {
  const Eigen::Vector3d& body_world = T_world_body.translation();
  HeightGridSpec spec;
  spec.first_xy = body_world.head<2>() - Eigen::Vector2d::Constant(kCell_m * kRobotCell);
  spec.cell_m = kCell_m;
  spec.num_x = spec.num_y = kCells;
  // What hangs over the robot is no ground.
  spec.z_max = body_world.z();
  const HeightGrid grid = query.Heights(spec);
  const double under = GroundUnder(query, body_world).value_or(ground_z_world);
  CheetahMaps maps;
  SetRobot(body_world, ground_z_world, &maps);
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const HeightCell& cell = grid.at(i, j);
      const double z = cell.known() ? static_cast<double>(cell.height_m) : under;
      maps.heights.map[i][j] = z - ground_z_world;
      const Eigen::Vector2d xy = spec.first_xy + kCell_m * Eigen::Vector2d(i, j);
      maps.traversability.map[i][j] = !cell.known()                                      ? kUnseenGround
                                      : MayStand(query, cell, {xy.x(), xy.y(), z}, foot) ? kMayStand
                                                                                         : kMayNotStand;
    }
  }
  return maps;
}

CheetahMaps CheetahMapsOfNothing(const Eigen::Vector3d& body_world, double ground_z_world) {
  CheetahMaps maps;
  SetRobot(body_world, ground_z_world, &maps);
  for (auto& row : maps.traversability.map) std::fill(std::begin(row), std::end(row), kUnseenGround);
  return maps;
}

localization_lcmt CheetahLocalization(const Eigen::Isometry3d& T_world_body, double ground_z_world) {
  localization_lcmt message{};
  const Eigen::Vector3d& p = T_world_body.translation();
  message.xyz[0] = static_cast<float>(p.x());
  message.xyz[1] = static_cast<float>(p.y());
  message.xyz[2] = static_cast<float>(p.z() - ground_z_world);
  const Eigen::Matrix3d& R = T_world_body.linear();
  message.rpy[0] = static_cast<float>(std::atan2(R(2, 1), R(2, 2)));
  message.rpy[1] = static_cast<float>(std::asin(std::clamp(-R(2, 0), -1.0, 1.0)));
  message.rpy[2] = static_cast<float>(std::atan2(R(1, 0), R(0, 0)));
  return message;
}

std::optional<double> GroundUnder(const TerrainQuery& query, const Eigen::Vector3d& body_world) {
  const auto ground = query.SupportAt(body_world.head<2>(), -std::numeric_limits<double>::infinity(),
                                      body_world.z(), kAllLabels);
  if (!ground) return std::nullopt;
  return ground->point_world.z();
}

}  // namespace terrace
