// SPDX-License-Identifier: BSD-3-Clause
#include "tools/surface_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {
namespace {

constexpr double kNear_m = 0.05;

/// What remains of a ring before the eye.
Ring ClipToFront(const Ring& ring_view) {
  Ring front;
  for (std::size_t i = 0; i < ring_view.size(); ++i) {
    const Eigen::Vector3d& a = ring_view[i];
    const Eigen::Vector3d& b = ring_view[(i + 1) % ring_view.size()];
    if (a.z() >= kNear_m) front.push_back(a);
    if ((a.z() >= kNear_m) != (b.z() >= kNear_m))
      front.push_back(a + (b - a) * ((kNear_m - a.z()) / (b.z() - a.z())));
  }
  return front;
}

}  // namespace

Projection Projection::OfCamera(const StereoCamera& camera, const Eigen::Isometry3d& T_world_left) {
  return {T_world_left.inverse(), true, camera.fx, camera.fy, camera.cx, camera.cy};
}

Projection Projection::Along(const Eigen::Vector3d& forward_world, const Eigen::Vector3d& up_world) {
  Projection projection;
  const Eigen::Vector3d z = forward_world.normalized();
  const Eigen::Vector3d x = z.cross(up_world).normalized();
  projection.T_view_world.linear().row(0) = x.transpose();
  projection.T_view_world.linear().row(1) = z.cross(x).transpose();
  projection.T_view_world.linear().row(2) = z.transpose();
  return projection;
}

bool Projection::InFront(const Eigen::Vector3d& p_world) const {
  return !perspective || (T_view_world * p_world).z() >= kNear_m;
}

Eigen::Vector2d Projection::Pixel(const Eigen::Vector3d& p_world) const {
  const Eigen::Vector3d p = T_view_world * p_world;
  const double w = perspective ? p.z() : 1.0;
  return {fx * p.x() / w + cx, fy * p.y() / w + cy};
}

SurfaceRaster::SurfaceRaster(int width, int height, const Projection& projection)
    : width_(width),
      height_(height),
      projection_(projection),
      depth_(static_cast<std::size_t>(width) * height, std::numeric_limits<float>::infinity()),
      index_(static_cast<std::size_t>(width) * height, -1) {}

void SurfaceRaster::Draw(const TerrainRegion& region, int index) {
  const Projection& p = projection_;
  const Eigen::Vector3d normal = p.T_view_world.linear() * region.plane_world.normal;
  const double offset = region.plane_world.offset_m + normal.dot(p.T_view_world.translation());
  // The eye is at the origin, or infinitely far behind it.
  if (p.perspective ? offset >= 0.0 : normal.z() >= -1e-6) return;

  std::vector<std::vector<Eigen::Vector2d>> rings;
  const auto add = [&](const Ring& ring_world) {
    Ring ring;
    for (const Eigen::Vector3d& q : ring_world) ring.push_back(p.T_view_world * q);
    if (p.perspective) ring = ClipToFront(ring);
    std::vector<Eigen::Vector2d> pixels;
    for (const Eigen::Vector3d& q : ring) {
      const double w = p.perspective ? q.z() : 1.0;
      pixels.emplace_back(p.fx * q.x() / w + p.cx, p.fy * q.y() / w + p.cy);
    }
    if (pixels.size() >= 3) rings.push_back(std::move(pixels));
  };
  add(region.outline_world);
  for (const Ring& hole : region.holes_world) add(hole);

  double top = std::numeric_limits<double>::infinity();
  double bottom = -top;
  for (const auto& ring : rings) {
    for (const Eigen::Vector2d& q : ring) {
      top = std::min(top, q.y());
      bottom = std::max(bottom, q.y());
    }
  }
  if (rings.empty() || bottom < 0.0 || top > height_ - 1) return;
  const int first = static_cast<int>(std::ceil(std::max(0.0, top)));
  const int last = static_cast<int>(std::floor(std::min<double>(height_ - 1, bottom)));
  std::vector<double> crossings;
  for (int v = first; v <= last; ++v) {
    crossings.clear();
    for (const auto& ring : rings) {
      for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
        if ((ring[j].y() > v) == (ring[i].y() > v)) continue;
        crossings.push_back(ring[j].x() +
                            (ring[i].x() - ring[j].x()) * (v - ring[j].y()) / (ring[i].y() - ring[j].y()));
      }
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
      const double begin = std::max(0.0, std::ceil(crossings[k]));
      const double end = std::min<double>(width_ - 1, std::floor(crossings[k + 1]));
      for (int u = static_cast<int>(begin); u <= end; ++u) {
        const double x = (u - p.cx) / p.fx;
        const double y = (v - p.cy) / p.fy;
        const double flat = normal.x() * x + normal.y() * y;
        const double z = p.perspective ? offset / (flat + normal.z()) : (offset - flat) / normal.z();
        const std::size_t pixel = static_cast<std::size_t>(v) * width_ + u;
        if (static_cast<float>(z) >= depth_[pixel]) continue;
        depth_[pixel] = static_cast<float>(z);
        index_[pixel] = index;
      }
    }
  }
}

}  // namespace terrace
