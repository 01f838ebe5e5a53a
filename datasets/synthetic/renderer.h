// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "datasets/synthetic/light_map.h"
#include "datasets/synthetic/ray_scene.h"

namespace terrace::synthetic {

struct RendererConfig {
  /// Samples a pixel, a power of two.
  int samples = 8;
  /// Threads that share the rows of an image; 0: all there are. The image does not depend on it.
  int num_threads = 0;

  std::vector<std::string> Problems() const;
};

/// Threads that this means, at most what the machine has.
int ThreadsOf(const RendererConfig& config);

/// Light that fell on the pixels of one camera, linear; 1 is white at gain 1.
struct Radiance {
  int width = 0;
  int height = 0;
  std::vector<float> data;  ///< row-major
};

/// What each pixel centre sees, without any averaging.
struct TrueView {
  int width = 0;
  int height = 0;
  std::vector<std::int32_t> surface;  ///< index into Scene::surfaces, or -1
  std::vector<float> depth_m;         ///< along the optical axis; 0: nothing
};

/// Looks into a scene. Poses are T_world_camera of an optical frame (x right, y down, z forward).
class Renderer {
 public:
  Renderer(const Scene& scene, const RendererConfig& config);

  /// @param pose_at  where the camera is, as a function of time: samples are spread over the exposure
  Radiance Render(const std::function<Eigen::Isometry3d(double t_s)>& pose_at, double t_s,
                  std::uint32_t seed);
  /// Rows from first_row on, every row_step-th; the others stay empty.
  TrueView Look(const Eigen::Isometry3d& T_world_camera, double t_s, int first_row = 0, int row_step = 1);

  const RayScene& rays() const { return rays_; }
  std::int64_t num_rays() const { return num_rays_; }  ///< traced for images so far

 private:
  struct RowBuffers;
  struct View;
  View ViewOf(const Eigen::Isometry3d& T_world_camera, double t_s) const;
  void AddSurfaceRun(const View& view, int surface, int first, int n, RowBuffers& row, float* sum) const;
  void AddMirrored(const View& view, int surface, int first, int n, RowBuffers& row, float* sum) const;

  const Scene& scene_;
  RendererConfig config_;
  RayScene rays_;
  LightMap light_;
  std::vector<SurfaceFrame> frames_;
  std::atomic<std::int64_t> num_rays_{0};
};

}  // namespace terrace::synthetic
