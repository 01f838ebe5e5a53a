// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "datasets/synthetic/scene.h"

namespace terrace::synthetic {

/// The surfaces of a scene for Embree, the only file that knows it. Embree says which surface a ray meets;
/// where is then computed from the surface's plane, which is exact.
class RayScene {
 public:
  explicit RayScene(const Scene& scene);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// Puts the moving objects where they are then. Not while others trace.
  void SetTime(double t_s);

  /// Index of the surface that each of `n` rays from one origin meets first, or -1.
  void Trace(const Eigen::Vector3f& origin, const float* dx, const float* dy, const float* dz, int n,
             std::int32_t* surface) const;
  /// The same for rays that are alike in nothing.
  void TraceEach(const float* ox, const float* oy, const float* oz, const float* dx, const float* dy,
                 const float* dz, int n, std::int32_t* surface) const;

  /// Whether anything that stands still lies on the ray within the reach; of up to 8 rays at once.
  /// @param reach  in lengths of the direction
  void Occluded8(const Eigen::Vector3f* origins, const Eigen::Vector3f* directions, float reach, int n,
                 bool* occluded) const;

  struct Hit {
    int surface = 0;
    double distance = 0.0;  ///< in lengths of the direction
  };
  std::optional<Hit> First(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  std::int64_t num_triangles() const;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace::synthetic
