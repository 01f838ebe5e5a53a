// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/renderer.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/field_problems.h"
#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

void Store(const Eigen::Vector3d& from, float* to) {
  for (int axis = 0; axis < 3; ++axis) to[axis] = static_cast<float>(from[axis]);
}

/// Coordinates 0 and 1 of the points of Sobol's sequence, as fractions of 2^32. With the time of the sample,
/// which rises with its index, any two of the three fill their square evenly, so moving edges are as smooth
/// as still ones.
std::uint32_t SobolDigits(std::uint32_t index, int coordinate) {
  std::uint32_t direction = 1U << 31;
  std::uint32_t digits = 0;
  for (; index != 0; index >>= 1) {
    if ((index & 1U) != 0) digits ^= direction;
    direction = coordinate == 0 ? direction >> 1 : direction ^ (direction >> 1);
  }
  return digits;
}

/// End of the run of equal numbers that starts at `first`.
int RunEnd(const std::int32_t* surface, int first, int n) {
  int end = first + 1;
  while (end < n && surface[end] == surface[first]) ++end;
  return end;
}

}  // namespace

int ThreadsOf(const RendererConfig& config) {
  const int most = tbb::info::default_concurrency();
  return config.num_threads > 0 ? std::min(config.num_threads, most) : most;
}

std::vector<std::string> RendererConfig::Problems() const {
  FieldProblems problems;
  problems.Require(samples >= 1 && samples <= 256 && (samples & (samples - 1)) == 0, "samples", samples,
                   "be a power of two up to 256");
  problems.RequireAtLeast("num_threads", num_threads, 0);
  return problems.Take();
}

/// Arrays for one row, reused by the rows of a thread.
struct Renderer::RowBuffers {
  explicit RowBuffers(int width) {
    const auto size = static_cast<std::size_t>(width + kRowPadding);
    for (auto* array : {&dx, &dy, &dz, &u, &v, &footprint, &depth, &albedo}) array->assign(size, 0.0F);
    surface.assign(size, -1);
  }
  std::vector<float> dx, dy, dz, u, v, footprint, depth, albedo;
  std::vector<std::int32_t> surface;
};

/// What is the same for all rays of one moment.
struct Renderer::View {
  Eigen::Vector3d origin;
  RowRays rays;
  std::vector<PlaneView> planes;  ///< of every surface
};

Renderer::Renderer(const Scene& scene, const RendererConfig& config)
    : scene_(scene), config_(config), rays_(scene), light_(scene, rays_, ThreadsOf(config)) {
  for (const Surface& surface : scene.surfaces) frames_.push_back(FrameOf(surface));
}

Renderer::View Renderer::ViewOf(const Eigen::Isometry3d& T_world_camera, double t_s) const {
  const StereoCamera& camera = scene_.camera;
  View view;
  view.origin = T_world_camera.translation();
  const Eigen::Matrix3d R = T_world_camera.rotation();
  Store(R.col(0) / camera.fx, view.rays.across);
  Store(R.col(1) / camera.fy, view.rays.down);
  Store(R * Eigen::Vector3d(-camera.cx / camera.fx, -camera.cy / camera.fy, 1.0), view.rays.base);
  view.rays.width = camera.width;
  const auto inverse_focal = static_cast<float>(1.0 / std::sqrt(camera.fx * camera.fy));
  view.planes.resize(scene_.surfaces.size());
  for (std::size_t s = 0; s < scene_.surfaces.size(); ++s) {
    const Surface& surface = scene_.surfaces[s];
    // A moving surface stands still in a frame that moves with it.
    Eigen::Vector3d eye = view.origin;
    if (surface.moving_object)
      eye -= scene_.moving[static_cast<std::size_t>(*surface.moving_object)].OffsetAt(t_s);
    PlaneView& plane = view.planes[s];
    Store(surface.plane_world.normal, plane.normal);
    Store(frames_[s].axis_u, plane.axis_u);
    Store(frames_[s].axis_v, plane.axis_v);
    plane.distance = static_cast<float>(-surface.plane_world.SignedDistance(eye));
    plane.origin_u = static_cast<float>(eye.dot(frames_[s].axis_u));
    plane.origin_v = static_cast<float>(eye.dot(frames_[s].axis_v));
    plane.inverse_focal = inverse_focal;
  }
  return view;
}

void Renderer::AddSurfaceRun(const View& view, int surface, int first, int n, RowBuffers& row,
                             float* sum) const {
  const auto s = static_cast<std::size_t>(surface);
  const Material& material = scene_.materials[static_cast<std::size_t>(scene_.surfaces[s].material)];
  MeetPlane(view.planes[s], &row.dx[first], &row.dy[first], &row.dz[first], n, row.u.data(), row.v.data(),
            row.footprint.data(), row.depth.data());
  EvaluateTexture(material, Hash(scene_.seed, static_cast<std::uint32_t>(surface)), row.u.data(),
                  row.v.data(), row.footprint.data(), n, row.albedo.data());
  AddLit(light_.grid(surface), row.u.data(), row.v.data(), row.albedo.data(), n, 1.0F, sum + first);
  if (material.mirror > 0.0) AddMirrored(view, surface, first, n, row, sum);
}

/// Adds what the polished surface shows of the others. Reflections of reflections are left out.
void Renderer::AddMirrored(const View& view, int surface, int first, int n, RowBuffers& row,
                           float* sum) const {
  const Surface& mirror = scene_.surfaces[static_cast<std::size_t>(surface)];
  const Material& material = scene_.materials[static_cast<std::size_t>(mirror.material)];
  const Eigen::Vector3f normal = mirror.plane_world.normal.cast<float>();
  const Eigen::Vector3f eye = view.origin.cast<float>();
  // Seen in a plane mirror the world is the world seen from the eye's image behind the mirror; the rays start
  // on the mirror.
  const Eigen::Vector3d image =
      view.origin - 2.0 * mirror.plane_world.SignedDistance(view.origin) * mirror.plane_world.normal;
  RowBuffers seen(n);
  std::vector<float> ox(static_cast<std::size_t>(n)), oy(ox), oz(ox), weight(ox);
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Vector3f direction(row.dx[static_cast<std::size_t>(first) + k],
                                    row.dy[static_cast<std::size_t>(first) + k],
                                    row.dz[static_cast<std::size_t>(first) + k]);
    const float slope = normal.dot(direction);
    const Eigen::Vector3f mirrored = direction - 2.0F * slope * normal;
    const Eigen::Vector3f start = eye + row.depth[k] * direction;
    ox[k] = start.x();
    oy[k] = start.y();
    oz[k] = start.z();
    seen.dx[k] = mirrored.x();
    seen.dy[k] = mirrored.y();
    seen.dz[k] = mirrored.z();
    // Schlick's approximation of Fresnel's equations.
    const float grazing = 1.0F - std::abs(slope) / direction.norm();
    const auto straight = static_cast<float>(material.mirror);
    weight[k] = straight + (1.0F - straight) * grazing * grazing * grazing * grazing * grazing;
  }
  rays_.TraceEach(ox.data(), oy.data(), oz.data(), seen.dx.data(), seen.dy.data(), seen.dz.data(), n,
                  seen.surface.data());
  for (int i = 0; i < n;) {
    const int end = RunEnd(seen.surface.data(), i, n);
    const int other = seen.surface[static_cast<std::size_t>(i)];
    if (other < 0) {
      for (int k = i; k < end; ++k) {
        sum[first + k] += weight[static_cast<std::size_t>(k)] * static_cast<float>(scene_.lighting.sky);
      }
    } else if (other != surface) {
      const auto s = static_cast<std::size_t>(other);
      PlaneView plane = view.planes[s];
      plane.distance = static_cast<float>(-scene_.surfaces[s].plane_world.SignedDistance(image));
      plane.origin_u = static_cast<float>(image.dot(frames_[s].axis_u));
      plane.origin_v = static_cast<float>(image.dot(frames_[s].axis_v));
      MeetPlane(plane, &seen.dx[static_cast<std::size_t>(i)], &seen.dy[static_cast<std::size_t>(i)],
                &seen.dz[static_cast<std::size_t>(i)], end - i, seen.u.data(), seen.v.data(),
                seen.footprint.data(), seen.depth.data());
      EvaluateTexture(scene_.materials[static_cast<std::size_t>(scene_.surfaces[s].material)],
                      Hash(scene_.seed, static_cast<std::uint32_t>(other)), seen.u.data(), seen.v.data(),
                      seen.footprint.data(), end - i, seen.albedo.data());
      for (int k = i; k < end; ++k) {
        seen.albedo[static_cast<std::size_t>(k - i)] *= weight[static_cast<std::size_t>(k)];
      }
      AddLit(light_.grid(other), seen.u.data(), seen.v.data(), seen.albedo.data(), end - i, 1.0F,
             sum + first + i);
    }
    i = end;
  }
}

Radiance Renderer::Render(const std::function<Eigen::Isometry3d(double)>& pose_at, double t_s,
                          std::uint32_t seed) {
  const int width = scene_.camera.width;
  const int height = scene_.camera.height;
  const int num_samples = config_.samples;
  rays_.SetTime(t_s);
  std::vector<View> views;
  for (int sample = 0; sample < num_samples; ++sample) {
    const double at = t_s + ((sample + 0.5) / num_samples - 0.5) * scene_.photometry.exposure_s;
    views.push_back(ViewOf(pose_at(at), t_s));
    RowRays& rays = views.back().rays;
    rays.sample_u = SobolDigits(static_cast<std::uint32_t>(sample), 0);
    rays.sample_v = SobolDigits(static_cast<std::uint32_t>(sample), 1);
    rays.jitter = true;
    rays.seed = seed;
  }
  Radiance image{width, height,
                 std::vector<float>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
  const auto render_rows = [&](const tbb::blocked_range<int>& range) {
    RowBuffers row(width);
    std::vector<float> sum(static_cast<std::size_t>(width + kRowPadding));
    for (int y = range.begin(); y < range.end(); ++y) {
      std::fill(sum.begin(), sum.end(), 0.0F);
      for (const View& view : views) {
        RowRays rays = view.rays;
        rays.row = y;
        GenerateRays(rays, row.dx.data(), row.dy.data(), row.dz.data());
        rays_.Trace(view.origin.cast<float>(), row.dx.data(), row.dy.data(), row.dz.data(), width,
                    row.surface.data());
        for (int x = 0; x < width;) {
          const int end = RunEnd(row.surface.data(), x, width);
          const int surface = row.surface[static_cast<std::size_t>(x)];
          if (surface >= 0) {
            AddSurfaceRun(view, surface, x, end - x, row, sum.data());
          } else {
            for (int k = x; k < end; ++k)
              sum[static_cast<std::size_t>(k)] += static_cast<float>(scene_.lighting.sky);
          }
          x = end;
        }
      }
      float* pixels = &image.data[static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
      for (int x = 0; x < width; ++x)
        pixels[x] = sum[static_cast<std::size_t>(x)] / static_cast<float>(num_samples);
    }
  };
  tbb::task_arena arena(ThreadsOf(config_));
  arena.execute([&] { tbb::parallel_for(tbb::blocked_range<int>(0, height, 4), render_rows); });
  num_rays_ += static_cast<std::int64_t>(width) * height * num_samples;
  return image;
}

TrueView Renderer::Look(const Eigen::Isometry3d& T_world_camera, double t_s, int first_row, int row_step) {
  const int width = scene_.camera.width;
  const int height = scene_.camera.height;
  rays_.SetTime(t_s);
  const View view = ViewOf(T_world_camera, t_s);
  TrueView truth{width, height, {}, {}};
  const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  truth.surface.assign(size, -1);
  truth.depth_m.resize(size);
  const int num_rows = (height - first_row + row_step - 1) / row_step;
  const auto look_at_rows = [&](const tbb::blocked_range<int>& range) {
    RowBuffers row(width);
    for (int i = range.begin(); i < range.end(); ++i) {
      const int y = first_row + i * row_step;
      RowRays rays = view.rays;
      rays.row = y;
      GenerateRays(rays, row.dx.data(), row.dy.data(), row.dz.data());
      rays_.Trace(view.origin.cast<float>(), row.dx.data(), row.dy.data(), row.dz.data(), width,
                  row.surface.data());
      const auto start = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      for (int x = 0; x < width;) {
        const int end = RunEnd(row.surface.data(), x, width);
        const auto at = static_cast<std::size_t>(x);
        if (row.surface[at] >= 0) {
          MeetPlane(view.planes[static_cast<std::size_t>(row.surface[at])], &row.dx[at], &row.dy[at],
                    &row.dz[at], end - x, row.u.data(), row.v.data(), row.footprint.data(), row.depth.data());
          std::copy_n(row.depth.begin(), end - x,
                      truth.depth_m.begin() + static_cast<std::ptrdiff_t>(start + at));
        }
        x = end;
      }
      std::copy_n(row.surface.begin(), width, truth.surface.begin() + static_cast<std::ptrdiff_t>(start));
    }
  };
  tbb::task_arena arena(ThreadsOf(config_));
  arena.execute([&] { tbb::parallel_for(tbb::blocked_range<int>(0, num_rows, 4), look_at_rows); });
  return truth;
}

}  // namespace terrace::synthetic
