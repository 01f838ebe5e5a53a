// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/elevation_map.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

constexpr double kPart_m = 0.01;  ///< footholds are given out in square centimetres

}  // namespace

ElevationMap::CellIndex ElevationMap::IndexOf(const Eigen::Vector2d& p) const {
  return {static_cast<std::int32_t>(std::floor(p.x() / config_.cell_m)),
          static_cast<std::int32_t>(std::floor(p.y() / config_.cell_m))};
}

std::int64_t ElevationMap::Key(const CellIndex& index) {
  return (static_cast<std::int64_t>(index.first) << 32) | static_cast<std::uint32_t>(index.second);
}

const ElevationMap::Cell* ElevationMap::Find(const CellIndex& index) const {
  const auto found = cells_.find(Key(index));
  return found == cells_.end() ? nullptr : &found->second;
}

void ElevationMap::Add(const FloatImage& disparity_px, const StereoCamera& camera,
                       const Eigen::Isometry3d& T_world_left) {
  ++frame_;
  const double min_variance_m2 = config_.min_sigma_m * config_.min_sigma_m;
  for (int v = 0; v < disparity_px.height; ++v) {
    for (int u = 0; u < disparity_px.width; ++u) {
      const double d = disparity_px.At(u, v);
      if (!(d > 0.0)) continue;
      const double depth_m = camera.Depth(d);
      const Eigen::Vector3d ray = T_world_left.linear() * Eigen::Vector3d((u - camera.cx) / camera.fx,
                                                                          (v - camera.cy) / camera.fy, 1.0);
      if (depth_m * ray.norm() > config_.max_range_m) continue;
      const Eigen::Vector3d p = T_world_left.translation() + depth_m * ray;
      if (p.z() > T_world_left.translation().z() + config_.max_above_camera_m) continue;
      // z = f b / d: an error of d moves the point along its ray.
      const double height_sigma_m = ray.z() * depth_m / d * config_.disparity_sigma_px;
      Fuse(IndexOf(p.head<2>()), p.z(), std::max(height_sigma_m * height_sigma_m, min_variance_m2));
    }
  }
}

void ElevationMap::Fuse(const CellIndex& index, double height_m, double variance_m2) {
  const auto [entry, is_new] = cells_.try_emplace(Key(index), Cell{height_m, variance_m2, frame_});
  if (is_new) return;
  Cell& cell = entry->second;
  const double off_m = height_m - cell.height_m;
  const double gate_m2 = config_.gate_sigmas * config_.gate_sigmas * cell.variance_m2;
  if (off_m * off_m > gate_m2) {
    if (cell.frame == frame_ && off_m < 0.0) return;
    if (cell.frame == frame_) {
      cell = {height_m, variance_m2, frame_};
    } else {
      cell.variance_m2 += config_.multi_height_noise_m * config_.multi_height_noise_m;
    }
    return;
  }
  const double sum_m2 = cell.variance_m2 + variance_m2;
  cell.height_m = (cell.variance_m2 * height_m + variance_m2 * cell.height_m) / sum_m2;
  cell.variance_m2 =
      std::max(cell.variance_m2 * variance_m2 / sum_m2, config_.min_sigma_m * config_.min_sigma_m);
  cell.frame = frame_;
}

std::optional<double> ElevationMap::HeightAt(const Eigen::Vector2d& p) const {
  const Cell* cell = Find(IndexOf(p));
  return cell != nullptr ? std::optional(cell->height_m) : std::nullopt;
}

std::optional<Eigen::Vector3d> ElevationMap::FitPlane(const CellIndex& index) const {
  // On the symmetric grid of nine cells least squares separate: mean, and slopes over the 6 cells aside.
  double heights[3][3];
  double mean = 0.0, along_x = 0.0, along_y = 0.0;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const Cell* cell = Find({index.first + i, index.second + j});
      if (cell == nullptr) return std::nullopt;
      heights[i + 1][j + 1] = cell->height_m;
      mean += cell->height_m / 9.0;
      along_x += i * cell->height_m / 6.0;
      along_y += j * cell->height_m / 6.0;
    }
  }
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const double residual_m = heights[i + 1][j + 1] - mean - i * along_x - j * along_y;
      if (std::abs(residual_m) >= config_.max_fit_residual_m) return std::nullopt;
    }
  }
  const Eigen::Vector3d plane(mean, along_x / config_.cell_m, along_y / config_.cell_m);
  if (std::atan(plane.tail<2>().norm()) > config_.max_slope_rad) return std::nullopt;
  return plane;
}

void ElevationMap::FindFootholds() {
  planes_.clear();
  for (const auto& [key, cell] : cells_) {
    const CellIndex index{static_cast<std::int32_t>(key >> 32), static_cast<std::int32_t>(key)};
    if (const auto plane = FitPlane(index)) planes_[index] = *plane;
  }
}

double ElevationMap::HeightOn(const CellIndex& index, const Eigen::Vector3d& plane,
                              const Eigen::Vector2d& p) const {
  const Eigen::Vector2d middle((index.first + 0.5) * config_.cell_m, (index.second + 0.5) * config_.cell_m);
  return plane.x() + plane.tail<2>().dot(p - middle);
}

void ElevationMap::ForEach(const Use& use) const {
  const int parts = std::max(1, static_cast<int>(std::lround(config_.cell_m / kPart_m)));
  for (const auto& [index, plane] : planes_) {
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; j < parts; ++j) {
        const Eigen::Vector2d p(config_.cell_m * (index.first + (i + 0.5) / parts),
                                config_.cell_m * (index.second + (j + 0.5) / parts));
        use({p.x(), p.y(), HeightOn(index, plane, p)}, false);
      }
    }
  }
}

bool ElevationMap::OfferAt(const Eigen::Vector3d& p, double height_m) const {
  const CellIndex index = IndexOf(p.head<2>());
  const auto found = planes_.find(index);
  return found != planes_.end() && std::abs(HeightOn(index, found->second, p.head<2>()) - p.z()) <= height_m;
}

}  // namespace terrace
