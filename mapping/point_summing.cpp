// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/point_summing.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "mapping/point_places.h"

namespace terrace {
namespace {

/// False for anything that is not a number.
bool InImage(const CloudPoint& point, const StereoCamera& camera) {
  return point.p_left.z() > 0.0F && point.u < camera.width && point.v < camera.height;
}

}  // namespace

bool IsCountable(const Eigen::Vector3d& p_world, const MappingConfig& config) {
  constexpr double kMost = 1 << 30;
  return p_world.allFinite() && p_world.cwiseAbs().maxCoeff() < kMost * config.leaf_size_m;
}

LeafIndex LeafAt(const Eigen::Vector3d& p_world, const MappingConfig& config) {
  TERRACE_CHECK(IsCountable(p_world, config), p_world.transpose());
  const double leaves_per_m = 1.0 / config.leaf_size_m;
  return (p_world * leaves_per_m).array().floor().cast<int>();
}

void SumPoints(const Cloud& cloud, const StereoCamera& camera, const Eigen::Isometry3d& T_world_left,
               const MappingConfig& config, FrameLeaves* leaves, ViewTiles* tiles) {
  leaves->Clear(camera.width);
  tiles->Clear(camera);
  const PointPlacer placer(camera, T_world_left, config);
  PlacedPoints placed;
  for (std::size_t first = 0; first < cloud.points.size(); first += PlacedPoints::kMost) {
    const CloudPoint* const points = cloud.points.data() + first;
    const std::size_t count = std::min(PlacedPoints::kMost, cloud.points.size() - first);
    placer.Place(points, count, &placed);
    // Leaves lie scattered over memory, which is asked for all of them before the first is added to.
    for (std::size_t i = 0; i < count; ++i) {
      if (!InImage(points[i], camera)) placed.weight[i] = 0.0F;
      if (placed.weight[i] == 0.0F) continue;
      leaves->Prefetch(placed.Address(i));
      tiles->Add(points[i].u, points[i].v, placed.disparity_px[i]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (placed.weight[i] == 0.0F) continue;
      leaves->At(placed.Address(i), points[i].u)
          .moments.Add(placed.weight[i], {placed.x_m[i], placed.y_m[i], placed.z_m[i]});
    }
  }
  const float fb = static_cast<float>(camera.fx * camera.baseline_m);
  // As near as they may well be.
  constexpr float kSigmas = 2.0F;
  for (const CloudPoint& point : cloud.uncertain) {
    if (!InImage(point, camera)) continue;
    const float z = point.p_left.z();
    tiles->Add(point.u, point.v, fb / z * (1.0F + kSigmas * point.sigma_depth_m / z));
  }
}

}  // namespace terrace
