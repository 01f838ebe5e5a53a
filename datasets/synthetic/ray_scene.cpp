// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/ray_scene.h"

#include <algorithm>
#include <limits>

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

#include "core/check.h"

namespace terrace::synthetic {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
/// Rays start this far from the eye.
constexpr float kNear = 0.01F;

struct Mesh {
  RTCGeometry geometry = nullptr;
  unsigned id = RTC_INVALID_GEOMETRY_ID;
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::int32_t> surface_of_triangle;
  std::vector<int> object_of_vertex;  ///< moving ones only
};

}  // namespace

struct RayScene::Impl {
  RTCDevice device = nullptr;
  RTCScene everything = nullptr;  ///< what cameras see
  RTCScene still = nullptr;       ///< what light is baked from and feet stand on
  Mesh still_mesh;
  Mesh moving_mesh;
  std::vector<MovingObject> objects;

  std::int32_t SurfaceOf(unsigned geometry, unsigned triangle) const {
    if (geometry == RTC_INVALID_GEOMETRY_ID) return -1;
    const Mesh& mesh = geometry == still_mesh.id ? still_mesh : moving_mesh;
    return mesh.surface_of_triangle[triangle];
  }

  /// Fans of all pieces of the surfaces that do or do not move.
  Mesh Build(const Scene& scene, bool moving) {
    Mesh mesh;
    std::vector<std::uint32_t> indices;
    for (std::size_t s = 0; s < scene.surfaces.size(); ++s) {
      const Surface& surface = scene.surfaces[s];
      if (surface.moving_object.has_value() != moving) continue;
      for (const Ring& piece : surface.pieces) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        for (const Eigen::Vector3d& vertex : piece) {
          mesh.vertices.push_back(vertex.cast<float>());
          mesh.object_of_vertex.push_back(surface.moving_object.value_or(-1));
        }
        for (std::uint32_t i = 2; i < piece.size(); ++i) {
          indices.insert(indices.end(), {first, first + i - 1, first + i});
          mesh.surface_of_triangle.push_back(static_cast<std::int32_t>(s));
        }
      }
    }
    if (indices.empty()) return mesh;
    mesh.geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(mesh.geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                                 RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                                 mesh.vertices.size()));
    auto* triangles = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(mesh.geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), indices.size() / 3));
    TERRACE_CHECK(vertices != nullptr && triangles != nullptr);
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      for (int axis = 0; axis < 3; ++axis) *vertices++ = vertex[axis];
    }
    std::copy(indices.begin(), indices.end(), triangles);
    rtcCommitGeometry(mesh.geometry);
    return mesh;
  }

  /// In one thread: the tree, and with it which of two surfaces wins on their common edge, must not depend on
  /// chance.
  static void Commit(RTCScene scene) {
    tbb::task_arena one(1);
    one.execute([scene] { rtcCommitScene(scene); });
  }
};

RayScene::RayScene(const Scene& scene) : impl_(std::make_unique<Impl>()) {
  impl_->device = rtcNewDevice(nullptr);
  TERRACE_CHECK(impl_->device != nullptr);
  impl_->objects = scene.moving;
  impl_->everything = rtcNewScene(impl_->device);
  impl_->still = rtcNewScene(impl_->device);
  rtcSetSceneFlags(impl_->everything, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneFlags(impl_->still, RTC_SCENE_FLAG_ROBUST);
  impl_->still_mesh = impl_->Build(scene, false);
  impl_->moving_mesh = impl_->Build(scene, true);
  if (impl_->still_mesh.geometry != nullptr) {
    impl_->still_mesh.id = rtcAttachGeometry(impl_->everything, impl_->still_mesh.geometry);
    rtcAttachGeometry(impl_->still, impl_->still_mesh.geometry);
  }
  if (impl_->moving_mesh.geometry != nullptr) {
    impl_->moving_mesh.id = rtcAttachGeometry(impl_->everything, impl_->moving_mesh.geometry);
  }
  Impl::Commit(impl_->everything);
  Impl::Commit(impl_->still);
}

RayScene::~RayScene() {
  for (const Mesh* mesh : {&impl_->still_mesh, &impl_->moving_mesh}) {
    if (mesh->geometry != nullptr) rtcReleaseGeometry(mesh->geometry);
  }
  rtcReleaseScene(impl_->everything);
  rtcReleaseScene(impl_->still);
  rtcReleaseDevice(impl_->device);
}

void RayScene::SetTime(double t_s) {
  Mesh& mesh = impl_->moving_mesh;
  if (mesh.geometry == nullptr) return;
  auto* vertices = static_cast<float*>(rtcGetGeometryBufferData(mesh.geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f offset =
        impl_->objects[static_cast<std::size_t>(mesh.object_of_vertex[i])].OffsetAt(t_s).cast<float>();
    for (int axis = 0; axis < 3; ++axis) *vertices++ = mesh.vertices[i][axis] + offset[axis];
  }
  rtcUpdateGeometryBuffer(mesh.geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(mesh.geometry);
  Impl::Commit(impl_->everything);
}

void RayScene::Trace(const Eigen::Vector3f& origin, const float* dx, const float* dy, const float* dz, int n,
                     std::int32_t* surface) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  constexpr int kPacket = 8;
  for (int first = 0; first < n; first += kPacket) {
    const int count = std::min(kPacket, n - first);
    alignas(32) RTCRayHit8 rays;
    alignas(32) int valid[kPacket];
    for (int i = 0; i < kPacket; ++i) {
      const int k = first + std::min(i, count - 1);
      valid[i] = i < count ? -1 : 0;
      rays.ray.org_x[i] = origin.x();
      rays.ray.org_y[i] = origin.y();
      rays.ray.org_z[i] = origin.z();
      rays.ray.dir_x[i] = dx[k];
      rays.ray.dir_y[i] = dy[k];
      rays.ray.dir_z[i] = dz[k];
      rays.ray.tnear[i] = kNear;
      rays.ray.tfar[i] = kFar;
      rays.ray.time[i] = 0.0F;
      rays.ray.mask[i] = ~0U;
      rays.ray.flags[i] = 0;
      rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid, impl_->everything, &context, &rays);
    for (int i = 0; i < count; ++i)
      surface[first + i] = impl_->SurfaceOf(rays.hit.geomID[i], rays.hit.primID[i]);
  }
}

void RayScene::TraceEach(const float* ox, const float* oy, const float* oz, const float* dx, const float* dy,
                         const float* dz, int n, std::int32_t* surface) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (int i = 0; i < n; ++i) {
    RTCRayHit ray{};
    ray.ray.org_x = ox[i];
    ray.ray.org_y = oy[i];
    ray.ray.org_z = oz[i];
    ray.ray.dir_x = dx[i];
    ray.ray.dir_y = dy[i];
    ray.ray.dir_z = dz[i];
    ray.ray.tnear = 1e-3F;
    ray.ray.tfar = kFar;
    ray.ray.mask = ~0U;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl_->everything, &context, &ray);
    surface[i] = impl_->SurfaceOf(ray.hit.geomID, ray.hit.primID);
  }
}

void RayScene::Occluded8(const Eigen::Vector3f* origins, const Eigen::Vector3f* directions, float reach,
                         int n, bool* occluded) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  constexpr int kPacket = 8;
  TERRACE_CHECK(n > 0 && n <= kPacket, n);
  alignas(32) RTCRay8 rays;
  alignas(32) int valid[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const int k = std::min(i, n - 1);
    valid[i] = i < n ? -1 : 0;
    rays.org_x[i] = origins[k].x();
    rays.org_y[i] = origins[k].y();
    rays.org_z[i] = origins[k].z();
    rays.dir_x[i] = directions[k].x();
    rays.dir_y[i] = directions[k].y();
    rays.dir_z[i] = directions[k].z();
    rays.tnear[i] = 0.0F;
    rays.tfar[i] = reach;
    rays.time[i] = 0.0F;
    rays.mask[i] = ~0U;
    rays.flags[i] = 0;
  }
  rtcOccluded8(valid, impl_->still, &context, &rays);
  for (int i = 0; i < n; ++i) occluded[i] = rays.tfar[i] < 0.0F;
}

std::optional<RayScene::Hit> RayScene::First(const Eigen::Vector3d& origin,
                                             const Eigen::Vector3d& direction) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  ray.ray.org_x = static_cast<float>(origin.x());
  ray.ray.org_y = static_cast<float>(origin.y());
  ray.ray.org_z = static_cast<float>(origin.z());
  ray.ray.dir_x = static_cast<float>(direction.x());
  ray.ray.dir_y = static_cast<float>(direction.y());
  ray.ray.dir_z = static_cast<float>(direction.z());
  ray.ray.tfar = kFar;
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->still, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return Hit{impl_->still_mesh.surface_of_triangle[ray.hit.primID], ray.ray.tfar};
}

std::int64_t RayScene::num_triangles() const {
  return static_cast<std::int64_t>(impl_->still_mesh.surface_of_triangle.size() +
                                   impl_->moving_mesh.surface_of_triangle.size());
}

}  // namespace terrace::synthetic
