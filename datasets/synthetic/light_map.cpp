// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/light_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

constexpr int kPacket = 8;
/// Rays to the light start this far off the surface.
constexpr double kLift = 2e-3;

/// Two numbers in [0, 1) that fill the square evenly as `index` grows (R2 sequence, M. Roberts), started
/// anywhere.
Eigen::Vector2d Even(int index, std::uint32_t start) {
  const double u = Unit(Hash(start, 1)) + 0.7548776662466927 * index;
  const double v = Unit(Hash(start, 2)) + 0.5698402909980532 * index;
  return {u - std::floor(u), v - std::floor(v)};
}

/// Collects weighted rays until eight are there, then asks which are free.
class Gatherer {
 public:
  Gatherer(const RayScene& rays, float reach) : rays_(rays), reach_(reach) {}
  void Add(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double weight) {
    origins_[count_] = origin.cast<float>();
    directions_[count_] = direction.cast<float>();
    weights_[count_] = weight;
    if (++count_ == kPacket) Flush();
  }
  double Sum() {
    if (count_ > 0) Flush();
    return sum_;
  }

 private:
  void Flush() {
    bool occluded[kPacket];
    rays_.Occluded8(origins_, directions_, reach_, count_, occluded);
    for (int i = 0; i < count_; ++i) {
      if (!occluded[i]) sum_ += weights_[i];
    }
    count_ = 0;
  }

  const RayScene& rays_;
  float reach_;
  Eigen::Vector3f origins_[kPacket];
  Eigen::Vector3f directions_[kPacket];
  double weights_[kPacket];
  int count_ = 0;
  double sum_ = 0.0;
};

double FromLamp(const Lamp& lamp, const RayScene& rays, const Eigen::Vector3d& p,
                const Eigen::Vector3d& normal, int num_rays, std::uint32_t seed) {
  Gatherer free(rays, 1.0F);
  const Eigen::Vector3d start = p + kLift * normal;
  if (lamp.distant) {
    const Eigen::Vector3d to_sun = -lamp.direction.normalized();
    const double facing = normal.dot(to_sun);
    if (facing <= 0.0) return 0.0;
    const PlaneAxes axes = AxesOf(to_sun);
    const int count = lamp.softness_rad > 0.0 ? num_rays : 1;
    constexpr double kFarAway = 100.0;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d at = Even(i, seed);
      const double radius = std::tan(lamp.softness_rad) * std::sqrt(at.x());
      const double angle = 2.0 * std::numbers::pi * at.y();
      const Eigen::Vector3d way = to_sun + radius * (std::cos(angle) * axes.x + std::sin(angle) * axes.y);
      free.Add(start, kFarAway * way, facing * lamp.strength / count);
    }
    return free.Sum();
  }
  for (int i = 0; i < num_rays; ++i) {
    const Eigen::Vector2d at = Even(i, seed) - Eigen::Vector2d(0.5, 0.5);
    const Eigen::Vector3d q =
        lamp.center + Eigen::Vector3d(at.x() * lamp.size_m.x(), at.y() * lamp.size_m.y(), 0.0);
    const Eigen::Vector3d way = q - start;
    const double square = std::max(way.squaredNorm(), 0.01);
    const double facing = normal.dot(way) / std::sqrt(square);
    const double down = way.z() / std::sqrt(square);  // the lamp shines downwards
    if (facing <= 0.0 || down <= 0.0) continue;
    // Stops short of the lamp: it may lie in the ceiling.
    free.Add(start, 0.995 * way, lamp.strength * facing * down / square / num_rays);
  }
  return free.Sum();
}

double FromAround(const Lighting& lighting, const RayScene& rays, const Eigen::Vector3d& p,
                  const Eigen::Vector3d& normal, std::uint32_t seed) {
  Gatherer free(rays, static_cast<float>(lighting.occlusion_reach_m));
  const PlaneAxes axes = AxesOf(normal);
  for (int i = 0; i < lighting.rays_per_texel; ++i) {
    // Cosine weighted: a disc lifted onto the hemisphere.
    const Eigen::Vector2d at = Even(i, seed);
    const double radius = std::sqrt(at.x());
    const double angle = 2.0 * std::numbers::pi * at.y();
    const Eigen::Vector3d way = radius * std::cos(angle) * axes.x + radius * std::sin(angle) * axes.y +
                                std::sqrt(1.0 - at.x()) * normal;
    free.Add(p + kLift * normal, way, lighting.ambient / lighting.rays_per_texel);
  }
  // What is hidden is lit too, only less.
  constexpr double kBounced = 0.3;
  return kBounced * lighting.ambient + (1.0 - kBounced) * free.Sum();
}

}  // namespace

SurfaceFrame FrameOf(const Surface& surface) {
  const PlaneAxes axes = AxesOf(surface.plane_world.normal);
  SurfaceFrame frame{axes.x, axes.y, 0.0, 0.0, 0.0, 0.0};
  frame.min_u = frame.min_v = std::numeric_limits<double>::max();
  frame.max_u = frame.max_v = std::numeric_limits<double>::lowest();
  for (const Eigen::Vector3d& vertex : surface.outline_world) {
    frame.min_u = std::min(frame.min_u, vertex.dot(axes.x));
    frame.max_u = std::max(frame.max_u, vertex.dot(axes.x));
    frame.min_v = std::min(frame.min_v, vertex.dot(axes.y));
    frame.max_v = std::max(frame.max_v, vertex.dot(axes.y));
  }
  return frame;
}

LightMap::LightMap(const Scene& scene, const RayScene& rays, int num_threads) {
  const double texel = scene.lighting.texel_m;
  values_.resize(scene.surfaces.size());
  grids_.resize(scene.surfaces.size());
  struct Row {
    int surface;
    int v;
  };
  std::vector<Row> rows;
  std::vector<SurfaceFrame> frames;
  for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
    const SurfaceFrame frame = FrameOf(scene.surfaces[s]);
    LightGrid& grid = grids_[s];
    grid.nu = std::max(2, static_cast<int>(std::ceil((frame.max_u - frame.min_u) / texel)) + 1);
    grid.nv = std::max(2, static_cast<int>(std::ceil((frame.max_v - frame.min_v) / texel)) + 1);
    grid.u0 = static_cast<float>(frame.min_u);
    grid.v0 = static_cast<float>(frame.min_v);
    grid.per_texel = static_cast<float>(1.0 / texel);
    values_[s].resize(static_cast<std::size_t>(grid.nu) * static_cast<std::size_t>(grid.nv));
    grid.values = values_[s].data();
    for (int v = 0; v < grid.nv; ++v) rows.push_back({static_cast<int>(s), v});
    frames.push_back(frame);
  }
  const auto bake_row = [&](const Row& row) {
    const auto s = static_cast<std::size_t>(row.surface);
    const Surface& surface = scene.surfaces[s];
    const SurfaceFrame& frame = frames[s];
    const Eigen::Vector3d& normal = surface.plane_world.normal;
    for (int u = 0; u < grids_[s].nu; ++u) {
      // Nodes beyond the outline count for what lies just inside it.
      constexpr double kInside = 1e-3;
      const double at_u = std::clamp(frame.min_u + u * texel, frame.min_u + kInside, frame.max_u - kInside);
      const double at_v =
          std::clamp(frame.min_v + row.v * texel, frame.min_v + kInside, frame.max_v - kInside);
      const Eigen::Vector3d p =
          at_u * frame.axis_u + at_v * frame.axis_v + surface.plane_world.offset_m * normal;
      const std::uint32_t seed = Hash(scene.seed, static_cast<std::uint32_t>(s),
                                      static_cast<std::uint32_t>(row.v * grids_[s].nu + u));
      double light = FromAround(scene.lighting, rays, p, normal, seed);
      for (std::size_t lamp = 0; lamp < scene.lighting.lamps.size(); ++lamp) {
        light += FromLamp(scene.lighting.lamps[lamp], rays, p, normal, scene.lighting.rays_per_texel,
                          Hash(seed, static_cast<std::uint32_t>(lamp)));
      }
      values_[s][static_cast<std::size_t>(row.v * grids_[s].nu + u)] = static_cast<float>(light);
    }
  };
  tbb::task_arena arena(num_threads);
  arena.execute(
      [&] { tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) { bake_row(rows[i]); }); });
}

}  // namespace terrace::synthetic
