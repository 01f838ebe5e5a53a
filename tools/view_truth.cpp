// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_truth.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <set>

#include <Eigen/Geometry>
#include <terrace/terrain_v1_t.hpp>

#include "core/print.h"
#include "lcmtypes/terrain_codec.h"

namespace terrace {
namespace {

Ring MovedRing(const Eigen::Isometry3d& T, const Ring& ring) {
  Ring moved;
  for (const Eigen::Vector3d& p : ring) moved.push_back(T * p);
  return moved;
}

/// @param id  positive
std::shared_ptr<const TerrainRegion> TrueRegion(const TruePolygon& polygon, std::int64_t id,
                                                const Eigen::Isometry3d& T_result_true) {
  auto region = std::make_shared<TerrainRegion>();
  region->id = id;
  region->revision = 1;
  region->label = TerrainLabelFromName(polygon.label).value_or(TerrainLabel::kUnknown);
  region->confidence = 1.0;
  region->why = "true: " + polygon.name + ", " + polygon.label;
  region->plane_world.normal = T_result_true.linear() * polygon.plane_world.normal;
  region->outline_world = MovedRing(T_result_true, polygon.outline_world);
  for (const Ring& hole : polygon.holes_world) region->holes_world.push_back(MovedRing(T_result_true, hole));
  region->centroid_world = region->outline_world.front();
  region->plane_world.offset_m = region->plane_world.normal.dot(region->centroid_world);
  region->area_m2 = polygon.area_m2;
  return region;
}

ViewBytes SurfacesRecord(const Evaluation& evaluation, const Eigen::Isometry3d& T_result_true) {
  constexpr std::size_t kOneMessage = std::numeric_limits<std::int32_t>::max();
  // Only what was asked for: ceilings would hide everything below.
  std::set<int> asked;
  for (const PolygonEvaluation& polygon : evaluation.map->polygons) asked.insert(polygon.id);
  TerrainMap map;
  map.t_capture = evaluation.result_map.t_capture;
  for (const TruePolygon& polygon : evaluation.scene.polygons) {
    if (!asked.contains(polygon.id) || polygon.outline_world.empty()) continue;
    map.regions.push_back(
        TrueRegion(polygon, static_cast<std::int64_t>(map.regions.size()) + 1, T_result_true));
  }
  return MakeViewRecord(ViewRecordKind::kTruth, map.t_capture, {},
                        SnapshotMessages(map, kOneMessage).front());
}

}  // namespace

std::vector<ViewBytes> RecordsOfTruth(const Evaluation& evaluation) {
  std::vector<ViewBytes> records;
  if (!evaluation.trajectory) return records;
  const Eigen::Isometry3d T_result_true =
      (evaluation.map ? evaluation.map->T_true_result : evaluation.trajectory->T_true_result).inverse();
  if (evaluation.map) records.push_back(SurfacesRecord(evaluation, T_result_true));
  std::vector<float> way;
  for (const TrajectorySample& sample : evaluation.trajectory->samples) {
    const Eigen::Vector3f p = (T_result_true * sample.p_true).cast<float>();
    way.insert(way.end(), {p.x(), p.y(), p.z()});
  }
  records.push_back(MakeViewRecord(ViewRecordKind::kTrueWay, {}, {}, way.data(), way.size() * sizeof(float)));
  return records;
}

std::vector<std::pair<std::string, std::string>> RowsOfTruth(const Evaluation& evaluation) {
  std::vector<std::pair<std::string, std::string>> rows;
  if (const auto& trajectory = evaluation.trajectory; trajectory && trajectory->num_matched > 0) {
    rows.emplace_back("way from the truth", Printed("%.1f mm rms, %.1f at most", 1e3 * trajectory->ate_rmse_m,
                                                    1e3 * trajectory->ate_max_m));
  }
  if (const auto& map = evaluation.map) {
    rows.emplace_back("true surfaces found", Printed("%.1f %%", 100.0 * map->coverage));
    rows.emplace_back("with the right label", Printed("%.1f %%", 100.0 * map->label_accuracy));
    rows.emplace_back("where nothing is", Printed("%.2f %% of the map", 100.0 * map->ghost_area));
    rows.emplace_back("heights of the ground", Printed("%.1f mm rms", 1e3 * map->support_plane_rms_m));
  }
  if (const auto& feet = evaluation.feet; feet && feet->unsupported_pct())
    rows.emplace_back("footholds on nothing", Printed("%.2f %%", *feet->unsupported_pct()));
  if (const auto& stairs = evaluation.staircases)
    rows.emplace_back("true staircases found", Printed("%d of %d", stairs->num_found, stairs->num_true));
  return rows;
}

}  // namespace terrace
