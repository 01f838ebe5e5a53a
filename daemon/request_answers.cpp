// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/request_answers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lcmtypes/codec_values.h"
#include "lcmtypes/request_codec.h"
#include "lcmtypes/terrain_codec.h"
#include "mapping/octomap_bytes.h"

namespace terrace {
namespace {

constexpr const char* kWorldFrame = "world";

}  // namespace

std::optional<Eigen::AlignedBox3d> BoxInWorld(const TerrainRequest& request, const AnswerSources& sources) {
  if (!request.around_robot) return request.box;
  if (!sources.T_world_left) return std::nullopt;
  return request.box.translated(sources.T_world_left->translation());
}

Eigen::Vector2d NumCells(const Eigen::AlignedBox3d& box, double resolution_m) {
  constexpr double kRounding = 1e-6;  // of a size that was meant to be a multiple
  const auto cells = [&](double size_m) {
    return std::max(1.0, std::ceil(size_m / resolution_m - kRounding));
  };
  return {cells(box.sizes().x()), cells(box.sizes().y())};
}

height_map_v1_t HeightMapAnswer(const TerrainQuery& query, std::int64_t map_id,
                                const Eigen::AlignedBox3d& box_world, double resolution_m) {
  const Eigen::Vector2i num = NumCells(box_world, resolution_m).cast<int>();
  HeightGridSpec spec;
  spec.first_xy = box_world.min().head<2>() + Eigen::Vector2d::Constant(0.5 * resolution_m);
  spec.cell_m = resolution_m;
  spec.num_x = num.x();
  spec.num_y = num.y();
  spec.z_min = box_world.min().z();
  spec.z_max = box_world.max().z();
  const HeightGrid grid = query.Heights(spec);

  height_map_v1_t message{};
  message.utime = query.map().t_capture.utime();
  message.seq = query.map().seq;
  message.map_id = map_id;
  message.frame_id = kWorldFrame;
  const Eigen::Vector2d centre =
      spec.first_xy + 0.5 * resolution_m * (num.cast<double>() - Eigen::Vector2d::Ones());
  message.center[0] = centre.x();
  message.center[1] = centre.y();
  message.resolution = static_cast<float>(resolution_m);
  message.nx = num.x();
  message.ny = num.y();
  message.layer_names = {"elevation", "variance", "label", "age"};
  message.n_layers = static_cast<std::int32_t>(message.layer_names.size());
  const std::size_t num_cells = grid.cells.size();
  message.values.assign(message.layer_names.size() * num_cells, HeightCell::kNotKnown);
  for (std::size_t i = 0; i < num_cells; ++i) {
    const HeightCell& cell = grid.cells[i];
    if (!cell.known()) continue;
    message.values[i] = cell.height_m;
    message.values[num_cells + i] = cell.sigma_m * cell.sigma_m;
    message.values[2 * num_cells + i] = static_cast<float>(cell.label);
    message.values[3 * num_cells + i] = cell.age_s;
  }
  message.n_values = static_cast<std::int32_t>(message.values.size());
  return message;
}

octree_v1_t OctreeAnswer(const AnswerSources& sources, std::vector<OccupiedLeaf> leaves,
                         const Eigen::AlignedBox3d& box_world) {
  octree_v1_t message{};
  message.utime = sources.map->t_capture.utime();
  message.seq = sources.map->seq;
  message.map_id = sources.map_id;
  message.frame_id = kWorldFrame;
  message.resolution = static_cast<float>(sources.octree->leaf_size_m());
  WriteVector(box_world.min(), message.box_min);
  WriteVector(box_world.max(), message.box_max);
  message.encoding = octree_v1_t::OCTOMAP_OT;
  message.data = OctomapBytes(std::move(leaves), sources.octree->leaf_size_m(), OctomapFormat::kOt);
  message.n_bytes = static_cast<std::int32_t>(message.data.size());
  return message;
}

disparity_v1_t DisparityAnswer(const AnswerSources& sources) {
  const cv::Mat1f& disparity_px = sources.disparity->disparity_px;
  disparity_v1_t message = DisparityHead(*sources.camera, sources.disparity->t_capture, sources.T_world_left);
  message.values.reserve(disparity_px.total());
  for (int v = 0; v < disparity_px.rows; ++v) {
    const float* row = disparity_px[v];
    for (int u = 0; u < disparity_px.cols; ++u) message.values.push_back(DisparityNumber(row[u]));
  }
  message.n_values = static_cast<std::int32_t>(message.values.size());
  return message;
}

std::vector<terrain_v1_t> MapAnswer(const TerrainQuery& query, std::int64_t map_id,
                                    const Eigen::AlignedBox3d& box_world) {
  const std::vector<std::int64_t> ids = query.RegionsIn(box_world);
  TerrainMap part = query.map();
  part.map_id = map_id;
  part.regions.clear();
  for (const std::int64_t id : ids) {
    const auto& all = query.map().regions;
    const auto region =
        std::lower_bound(all.begin(), all.end(), id, [](const auto& a, std::int64_t b) { return a->id < b; });
    part.regions.push_back(*region);
  }
  std::erase_if(part.staircases, [&](const Staircase& staircase) {
    return std::none_of(part.regions.begin(), part.regions.end(),
                        [&](const auto& region) { return region->staircase_id == staircase.id; });
  });
  return SnapshotMessages(part);
}

}  // namespace terrace
