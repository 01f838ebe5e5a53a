// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/well_seen.h"

#include <algorithm>
#include <cmath>

#include "evaluation/map_shapes.h"

namespace terrace {
namespace {

constexpr int kPixelsOfCell = 4;
constexpr double kWellSeenRange_m = 2.5;
constexpr int kFrames = 2;

}  // namespace

WellSeenCells::WellSeenCells(const TrueScene& scene) {
  for (const TruePolygon& polygon : scene.polygons) {
    if (!IsWalkable(polygon.label) || polygon.detail) continue;
    const std::size_t num_cells = polygon.observed.seen.size();
    counts_[polygon.id] = {&polygon, std::vector<std::uint16_t>(num_cells),
                           std::vector<std::uint16_t>(num_cells)};
  }
}

void WellSeenCells::Add(const Gray16Image& labels, const StereoCamera& camera,
                        const Eigen::Isometry3d& T_world_left) {
  for (auto& [id, counts] : counts_) std::fill(counts.pixels.begin(), counts.pixels.end(), 0);
  const Eigen::Vector3d eye = T_world_left.translation();
  for (int v = 0; v < labels.height; ++v) {
    for (int u = 0; u < labels.width; ++u) {
      const auto found =
          counts_.find(labels.data[static_cast<std::size_t>(v) * static_cast<std::size_t>(labels.width) +
                                   static_cast<std::size_t>(u)]);
      if (found == counts_.end()) continue;
      const TruePolygon& polygon = *found->second.polygon;
      const Eigen::Vector3d ray = T_world_left.linear() * Eigen::Vector3d((u - camera.cx) / camera.fx,
                                                                          (v - camera.cy) / camera.fy, 1.0);
      const double depth_m = -polygon.plane_world.SignedDistance(eye) / polygon.plane_world.normal.dot(ray);
      if (!(depth_m > 0.0) || depth_m * ray.norm() > kWellSeenRange_m) continue;
      const ObservedCells& cells = polygon.observed;
      const Eigen::Vector3d p = eye + depth_m * ray;
      const double i = std::floor((cells.axis_x.dot(p) - cells.origin_m.x()) / cells.cell_m);
      const double j = std::floor((cells.axis_y.dot(p) - cells.origin_m.y()) / cells.cell_m);
      if (!(i >= 0 && i < cells.nx && j >= 0 && j < cells.ny)) continue;
      ++found->second.pixels[static_cast<std::size_t>(i) * static_cast<std::size_t>(cells.ny) +
                             static_cast<std::size_t>(j)];
    }
  }
  for (auto& [id, counts] : counts_) {
    for (std::size_t k = 0; k < counts.pixels.size(); ++k) {
      if (counts.pixels[k] >= kPixelsOfCell) ++counts.frames[k];
    }
  }
}

CellsOfPolygons WellSeenCells::Cells() const {
  CellsOfPolygons all;
  for (const auto& [id, counts] : counts_) {
    ObservedCells cells = counts.polygon->observed;
    for (std::size_t k = 0; k < cells.seen.size(); ++k) cells.seen[k] = counts.frames[k] >= kFrames ? 1 : 0;
    all[id] = std::move(cells);
  }
  return all;
}

}  // namespace terrace
