// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"
#include "datasets/synthetic/hash.h"
#include "datasets/synthetic/scene_solids.h"

namespace terrace::synthetic {
namespace {

/// A solid stands on a floor when their heights agree this well.
constexpr double kContact_m = 1e-3;
/// Faces smaller than this need not be found by a mapper.
constexpr double kDetailArea_m2 = 0.02;
/// Up to this slope a ramp is walked like a floor.
constexpr double kWalkwaySlope_rad = 8.0 * std::numbers::pi / 180.0;

Plane PlaneOf(const Ring& ring) {
  // Newell's normal: exact for a planar ring of any shape.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    normal += (ring[i] - ring[0]).cross(ring[(i + 1) % ring.size()] - ring[0]);
    middle += ring[i] / static_cast<double>(ring.size());
  }
  normal.normalize();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) < 1e-12) normal[axis] = 0.0;
  }
  normal.normalize();
  return {normal, normal.dot(middle)};
}

bool InsideConvex(const Ring& ring, const Eigen::Vector3d& normal, const Eigen::Vector3d& p,
                  double margin_m) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector3d edge = (ring[(i + 1) % ring.size()] - ring[i]).normalized();
    if (normal.cross(edge).dot(p - ring[i]) < margin_m) return false;
  }
  return true;
}

}  // namespace

Surface& SceneBuilder::AddFace(const std::string& name, const std::string& label, const Ring& outline,
                               int material) {
  Surface surface;
  surface.name = name;
  surface.label = label;
  surface.plane_world = PlaneOf(outline);
  surface.outline_world = outline;
  surface.pieces = {outline};
  surface.material = material;
  scene_.surfaces.push_back(std::move(surface));
  return scene_.surfaces.back();
}

void SceneBuilder::AddFloor(const FloorSpec& s, int material) {
  Ring ring{{s.min.x(), s.min.y(), s.z_m},
            {s.max.x(), s.min.y(), s.z_m},
            {s.max.x(), s.max.y(), s.z_m},
            {s.min.x(), s.max.y(), s.z_m}};
  if (s.faces_down) std::reverse(ring.begin(), ring.end());
  AddFace(s.name, s.label, ring, material);
}

void SceneBuilder::AddBox(const BoxSpec& s, int material) {
  Eigen::Isometry3d T = GroundFrame(s.base_center, s.yaw_rad);
  if (s.tilt_rad != 0.0) {
    T.linear() = T.linear() * Eigen::AngleAxisd(s.tilt_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
    T.translation().z() -= 0.5 * s.size_m.z();
  }
  const Eigen::Vector3d h = 0.5 * s.size_m;
  const double top = s.size_m.z();
  const std::string side = s.side_label.empty() ? UprightLabel(top) : s.side_label;
  const auto face = [&](const std::string& which, const std::string& label,
                        const std::vector<Eigen::Vector3d>& corners) {
    Surface& surface = AddFace(s.name + "/" + which, label, Placed(T, corners), material);
    surface.detail = s.detail;
  };
  face("top", s.top_label,
       {{-h.x(), -h.y(), top}, {h.x(), -h.y(), top}, {h.x(), h.y(), top}, {-h.x(), h.y(), top}});
  face("-y", side, {{-h.x(), -h.y(), 0}, {h.x(), -h.y(), 0}, {h.x(), -h.y(), top}, {-h.x(), -h.y(), top}});
  face("+x", side, {{h.x(), -h.y(), 0}, {h.x(), h.y(), 0}, {h.x(), h.y(), top}, {h.x(), -h.y(), top}});
  face("+y", side, {{h.x(), h.y(), 0}, {-h.x(), h.y(), 0}, {-h.x(), h.y(), top}, {h.x(), h.y(), top}});
  face("-x", side, {{-h.x(), h.y(), 0}, {-h.x(), -h.y(), 0}, {-h.x(), -h.y(), top}, {-h.x(), h.y(), top}});
  if (s.tilt_rad == 0.0) {
    AddFootprint(Placed(T, {{-h.x(), -h.y(), 0}, {h.x(), -h.y(), 0}, {h.x(), h.y(), 0}, {-h.x(), h.y(), 0}}));
  }
}

void SceneBuilder::AddMovingBox(const BoxSpec& s, const std::vector<MovingObject::Key>& keys, int material) {
  const std::size_t first = scene_.surfaces.size();
  AddBox(s, material);
  footprints_.pop_back();  // the floor under it is seen when it has gone
  for (std::size_t i = first; i < scene_.surfaces.size(); ++i) {
    scene_.surfaces[i].moving_object = static_cast<int>(scene_.moving.size());
  }
  MovingObject object;
  object.name = s.name;
  object.keys = keys;
  object.base_center = s.base_center;
  object.size_m = s.size_m;
  object.yaw_rad = s.yaw_rad;
  scene_.moving.push_back(std::move(object));
}

void SceneBuilder::AddQuad(const QuadSpec& s, int material) {
  Surface& surface = AddFace(s.name, s.label, {s.corners.begin(), s.corners.end()}, material);
  surface.detail = s.detail;
}

void SceneBuilder::AddRamp(const RampSpec& s, int material) {
  const Eigen::Isometry3d T = GroundFrame(s.foot, s.yaw_rad);
  const double half = 0.5 * s.width_m;
  const double tail = s.length_m + s.landing_m;
  const bool gentle = std::atan2(s.rise_m, s.length_m) <= kWalkwaySlope_rad;
  AddFace(
      s.name, gentle ? "walkway" : "ramp",
      Placed(T, {{0, -half, 0}, {s.length_m, -half, s.rise_m}, {s.length_m, half, s.rise_m}, {0, half, 0}}),
      material);
  if (s.landing_m > 0.0) {
    AddFace(s.name + "/landing", "walkway",
            Placed(T, {{s.length_m, -half, s.rise_m},
                       {tail, -half, s.rise_m},
                       {tail, half, s.rise_m},
                       {s.length_m, half, s.rise_m}}),
            material);
  }
  AddFace(s.name + "/back", UprightLabel(s.rise_m),
          Placed(T, {{tail, -half, 0}, {tail, half, 0}, {tail, half, s.rise_m}, {tail, -half, s.rise_m}}),
          material);
  for (const double side : {half, -half}) {
    std::vector<Eigen::Vector3d> profile{{0, side, 0}, {tail, side, 0}, {tail, side, s.rise_m}};
    if (s.landing_m > 0.0) profile.push_back({s.length_m, side, s.rise_m});
    if (side > 0.0) std::reverse(profile.begin(), profile.end());
    AddFace(s.name + (side > 0.0 ? "/side left" : "/side right"), UprightLabel(s.rise_m), Placed(T, profile),
            material);
  }
  AddFootprint(Placed(T, {{0, -half, 0}, {tail, -half, 0}, {tail, half, 0}, {0, half, 0}}));
}

void SceneBuilder::AddRubble(const RubbleSpec& s, int material) {
  Random random(s.seed);
  const double middle_y = 0.5 * (s.min.y() + s.max.y());
  for (int i = 0; i < s.count; ++i) {
    BoxSpec box;
    box.name = s.name + std::to_string(i + 1);
    box.base_center = {random.Uniform(s.min.x(), s.max.x()), random.Uniform(s.min.y(), s.max.y()), s.z_m};
    box.size_m = {random.Uniform(s.min_size_m, s.max_size_m), random.Uniform(s.min_size_m, s.max_size_m),
                  2.0 * random.Uniform(0.25, 1.0) * s.max_height_m};
    box.yaw_rad = random.Uniform(0.0, 2.0 * std::numbers::pi);
    box.tilt_rad = std::max(0.02, random.Uniform() * s.max_tilt_rad);
    if (std::abs(box.base_center.y() - middle_y) < s.clear_m) continue;
    box.side_label = "obstacle";
    box.detail = box.size_m.x() * box.size_m.y() < kDetailArea_m2;
    AddBox(box, material);
  }
}

void SceneBuilder::Finish() {
  int id = 0;
  for (Surface& surface : scene_.surfaces) {
    ++id;
    surface.image_id = id;
    if (surface.moving_object) continue;
    if (surface.staircase_id) {
      scene_.staircases[static_cast<std::size_t>(*surface.staircase_id - 1)].truth.polygon_ids.push_back(id);
    }
    if (surface.plane_world.normal.z() < 0.99999 || surface.pieces.size() != 1) continue;
    for (const Ring& footprint : footprints_) {
      const bool inside = std::all_of(footprint.begin(), footprint.end(), [&](const Eigen::Vector3d& corner) {
        return std::abs(surface.plane_world.SignedDistance(corner)) < kContact_m &&
               InsideConvex(surface.outline_world, surface.plane_world.normal, corner, kContact_m);
      });
      if (inside) surface.holes_world.push_back(footprint);
    }
  }
  for (MovingObject& object : scene_.moving) object.mesh_id = ++id;
  for (Surface& surface : scene_.surfaces) {
    if (surface.moving_object)
      surface.image_id = scene_.moving[static_cast<std::size_t>(*surface.moving_object)].mesh_id;
  }
}

}  // namespace terrace::synthetic
