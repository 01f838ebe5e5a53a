// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/point_summing.h"

#include <array>
#include <cmath>

#include "core/check.h"
#include "core/rounding.h"

namespace terrace {
namespace {

/// False for anything that is not a number.
bool InImage(const CloudPoint& point, const StereoCamera& camera) {
  return point.p_left.z() > 0.0F && point.u < camera.width && point.v < camera.height;
}

/// A point of the frame and the leaf that it falls into.
struct PlacedPoint {
  LeafAddress address;
  Eigen::Vector3f offset;  ///< from the centre of the leaf [m]
  float weight;            ///< 1 / variance
  int u;                   ///< column of its pixel
};

/// Level l is used up to the depth at l, while a leaf is min_leaf_px wide; the last one beyond.
class LeafLevels {
 public:
  LeafLevels(const MappingConfig& config, const StereoCamera& camera)
      : coarsest_(CoarsestLevel(config.leaves_per_cell)) {
    for (int level = 0; level < coarsest_; ++level)
      max_z_[static_cast<std::size_t>(level)] =
          static_cast<float>(config.leaf_size_m * (1 << level) * camera.fx / config.min_leaf_px);
  }
  int At(float z) const {
    int level = 0;
    while (level < coarsest_ && z > max_z_[static_cast<std::size_t>(level)]) ++level;
    return level;
  }

 private:
  const int coarsest_;
  std::array<float, 8> max_z_{};
};

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
  // In units of the finest leaf; the camera's own leaf is split off, so that floats suffice for what is left.
  const double leaves_per_m = 1.0 / config.leaf_size_m;
  const LeafIndex camera_leaf = LeafAt(T_world_left.translation(), config);
  const Eigen::Vector3f in_camera_leaf =
      (T_world_left.translation() * leaves_per_m - camera_leaf.cast<double>()).cast<float>();
  const Eigen::Matrix3f R = (T_world_left.linear() * leaves_per_m).cast<float>();
  const float pose_variance = static_cast<float>(config.pose_sigma_m * config.pose_sigma_m);
  const float sigma_factor = static_cast<float>(config.depth_sigma_factor);
  const float leaf_m = static_cast<float>(config.leaf_size_m);
  const float fb = static_cast<float>(camera.fx * camera.baseline_m);
  const LeafLevels levels(config, camera);
  // Leaves lie scattered over memory, which is asked for a batch of them before the first is added to.
  std::array<PlacedPoint, 32> batch;
  std::size_t num_placed = 0;
  const auto add_batch = [&] {
    for (std::size_t i = 0; i < num_placed; ++i)
      leaves->At(batch[i].address, batch[i].u).moments.Add(batch[i].weight, batch[i].offset);
    num_placed = 0;
  };
  for (const CloudPoint& point : cloud.points) {
    const float sigma = sigma_factor * point.sigma_depth_m;
    const float variance = sigma * sigma + pose_variance;
    const Eigen::Vector3f p = R * point.p_left + in_camera_leaf;
    // Also false for anything that is not a number.
    const auto within = [](float x) { return std::abs(x) < kMaxReachLeaves; };
    if (!(InImage(point, camera) && variance > 0.0F && within(p.x()) && within(p.y()) && within(p.z())))
      continue;
    const int level = levels.At(point.p_left.z());
    const Eigen::Vector3i floor(FloorToInt(p.x()), FloorToInt(p.y()), FloorToInt(p.z()));
    LeafIndex corner = camera_leaf + floor;
    Eigen::Vector3f offset =
        p - floor.cast<float>() - Eigen::Vector3f::Constant(0.5F * static_cast<float>(1 << level));
    for (int i = 0; i < 3; ++i) {
      const int low = (corner[i] >> level) << level;
      offset[i] += static_cast<float>(corner[i] - low);
      corner[i] = low;
    }
    PlacedPoint& placed = batch[num_placed++];
    placed = {LeafAddress(corner, level), offset * leaf_m, 1.0F / variance, point.u};
    leaves->Prefetch(placed.address);
    if (num_placed == batch.size()) add_batch();
    tiles->Add(point.u, point.v, fb / point.p_left.z());
  }
  add_batch();
  // As near as they may well be.
  constexpr float kSigmas = 2.0F;
  for (const CloudPoint& point : cloud.uncertain) {
    if (!InImage(point, camera)) continue;
    const float z = point.p_left.z();
    tiles->Add(point.u, point.v, fb / z * (1.0F + kSigmas * point.sigma_depth_m / z));
  }
}

}  // namespace terrace
