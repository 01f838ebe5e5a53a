// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "datasets/synthetic/ray_scene.h"
#include "datasets/synthetic/row_kernels.h"

namespace terrace::synthetic {

/// The axes in which a surface's texture and light are laid out, and where they begin.
struct SurfaceFrame {
  Eigen::Vector3d axis_u;
  Eigen::Vector3d axis_v;
  double min_u = 0.0;  ///< extent of the outline along the axes
  double max_u = 0.0;
  double min_v = 0.0;
  double max_v = 0.0;
};
SurfaceFrame FrameOf(const Surface& surface);

/// The light that falls on each surface from lamps, sun and surroundings, with soft shadows and corners that
/// are darker: computed once, so that rendering needs one ray a sample. Moving objects neither receive nor
/// cast shadows of others.
class LightMap {
 public:
  LightMap(const Scene& scene, const RayScene& rays, int num_threads);

  const LightGrid& grid(int surface) const { return grids_[static_cast<std::size_t>(surface)]; }

 private:
  std::vector<std::vector<float>> values_;
  std::vector<LightGrid> grids_;
};

}  // namespace terrace::synthetic
