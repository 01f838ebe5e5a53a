// SPDX-License-Identifier: BSD-3-Clause
// What rendering costs beside Embree's own work: the same rays into the same triangles, 640x480, the demo's
// scene. One thread each, so that the figures are those of a core.
#include <limits>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include "datasets/synthetic/renderer.h"
#include "datasets/synthetic/row_kernels.h"
#include "datasets/synthetic/scene_file.h"
#include "datasets/synthetic/sensors.h"
#include "datasets/synthetic/synthesis.h"

namespace terrace::synthetic {
namespace {

constexpr int kPacket = 8;
constexpr int kSamples = 8;

/// The demo, seen from where the robot starts.
struct Demo {
  Scene scene = LoadScene(FindScene("demo"));
  Renderer renderer{scene, {kSamples, 1}};
  Eigen::Isometry3d T_world_left =
      PlanMotionIn(scene, renderer.rays(), 1).PoseAt(0.0) * scene.mounting.T_body_left();
};

Demo& TheDemo() {
  static Demo demo;
  return demo;
}

/// Directions of all pixels, row by row.
struct Directions {
  std::vector<float> dx, dy, dz;
};

Directions AllDirections(const Demo& demo) {
  const StereoCamera& camera = demo.scene.camera;
  Directions all;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d d =
          demo.T_world_left.linear() *
          Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      all.dx.push_back(static_cast<float>(d.x()));
      all.dy.push_back(static_cast<float>(d.y()));
      all.dz.push_back(static_cast<float>(d.z()));
    }
  }
  return all;
}

void CountRays(benchmark::State& state, std::int64_t rays_per_iteration) {
  state.counters["rays/s"] = benchmark::Counter(static_cast<double>(state.iterations() * rays_per_iteration),
                                                benchmark::Counter::kIsRate);
}

/// Embree alone: packets laid out beforehand, only what a ray needs to be traced again is reset.
void EmbreeAlone(benchmark::State& state) {
  const Demo& demo = TheDemo();
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
  for (const Surface& surface : demo.scene.surfaces) {
    for (const Ring& piece : surface.pieces) {
      const auto first = static_cast<std::uint32_t>(vertices.size() / 3);
      for (const Eigen::Vector3d& p : piece) {
        for (int axis = 0; axis < 3; ++axis) vertices.push_back(static_cast<float>(p[axis]));
      }
      for (std::uint32_t i = 2; i < piece.size(); ++i)
        indices.insert(indices.end(), {first, first + i - 1, first + i});
    }
  }
  std::copy(
      vertices.begin(), vertices.end(),
      static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                  3 * sizeof(float), vertices.size() / 3)));
  std::copy(indices.begin(), indices.end(),
            static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                                RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t),
                                                                indices.size() / 3)));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  const Directions all = AllDirections(demo);
  std::vector<RTCRayHit8> packets(all.dx.size() / kPacket);
  const Eigen::Vector3f eye = demo.T_world_left.translation().cast<float>();
  for (std::size_t p = 0; p < packets.size(); ++p) {
    for (int i = 0; i < kPacket; ++i) {
      const std::size_t k = p * kPacket + static_cast<std::size_t>(i);
      packets[p].ray.org_x[i] = eye.x();
      packets[p].ray.org_y[i] = eye.y();
      packets[p].ray.org_z[i] = eye.z();
      packets[p].ray.dir_x[i] = all.dx[k];
      packets[p].ray.dir_y[i] = all.dy[k];
      packets[p].ray.dir_z[i] = all.dz[k];
      packets[p].ray.tnear[i] = 0.01F;
      packets[p].ray.time[i] = 0.0F;
      packets[p].ray.mask[i] = ~0U;
      packets[p].ray.flags[i] = 0;
    }
  }
  alignas(32) const int valid[kPacket] = {-1, -1, -1, -1, -1, -1, -1, -1};
  for (auto _ : state) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (RTCRayHit8& packet : packets) {
      for (int i = 0; i < kPacket; ++i) {
        packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
        packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      }
      rtcIntersect8(valid, scene, &context, &packet);
    }
    benchmark::DoNotOptimize(packets.data());
  }
  CountRays(state, static_cast<std::int64_t>(all.dx.size()));
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
}
BENCHMARK(EmbreeAlone)->Unit(benchmark::kMillisecond);

void OurTrace(benchmark::State& state) {
  const Demo& demo = TheDemo();
  const Directions all = AllDirections(demo);
  std::vector<std::int32_t> surface(all.dx.size());
  for (auto _ : state) {
    demo.renderer.rays().Trace(demo.T_world_left.translation().cast<float>(), all.dx.data(), all.dy.data(),
                               all.dz.data(), static_cast<int>(all.dx.size()), surface.data());
    benchmark::DoNotOptimize(surface.data());
  }
  CountRays(state, static_cast<std::int64_t>(all.dx.size()));
}
BENCHMARK(OurTrace)->Unit(benchmark::kMillisecond);

void RenderImage(benchmark::State& state) {
  Demo& demo = TheDemo();
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        demo.renderer.Render([&](double) { return demo.T_world_left; }, 0.0, 1).data.data());
  }
  CountRays(state, static_cast<std::int64_t>(demo.scene.camera.width) * demo.scene.camera.height * kSamples);
  state.counters["pairs/s"] =
      benchmark::Counter(0.5 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(RenderImage)->Unit(benchmark::kMillisecond);

void ExposeImage(benchmark::State& state) {
  Demo& demo = TheDemo();
  const Radiance light = demo.renderer.Render([&](double) { return demo.T_world_left; }, 0.0, 1);
  const ImageSensor sensor(demo.scene.photometry);
  for (auto _ : state) benchmark::DoNotOptimize(sensor.Expose(light, 1.0, 7).data.data());
}
BENCHMARK(ExposeImage)->Unit(benchmark::kMillisecond);

/// One row of a surface 1.5 m away.
void Texture(benchmark::State& state) {
  Material material;
  material.pattern = static_cast<Pattern>(state.range(0));
  state.SetLabel(Name(material.pattern));
  constexpr int kWidth = 640;
  std::vector<float> u(kWidth + kRowPadding), v(u), footprint(u.size(), 0.004F), albedo(u);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = 0.004F * static_cast<float>(i);
  for (auto _ : state) {
    EvaluateTexture(material, 3, u.data(), v.data(), footprint.data(), kWidth, albedo.data());
    benchmark::DoNotOptimize(albedo.data());
  }
  state.counters["samples/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * kWidth, benchmark::Counter::kIsRate);
}
BENCHMARK(Texture)->DenseRange(0, kNumPatterns - 1);

}  // namespace
}  // namespace terrace::synthetic
