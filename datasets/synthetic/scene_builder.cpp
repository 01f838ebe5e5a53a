// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/check.h"
#include "datasets/synthetic/hash.h"

namespace terrace::synthetic {
namespace {

/// What rises this far is a wall (DESIGN.md, "Labels").
constexpr double kWallHeight_m = 1.0;
/// A solid stands on a floor when their heights agree this well.
constexpr double kContact_m = 1e-3;
/// Faces smaller than this need not be found by a mapper.
constexpr double kDetailArea_m2 = 0.02;
/// Up to this slope a ramp is walked like a floor.
constexpr double kWalkwaySlope_rad = 8.0 * std::numbers::pi / 180.0;

std::string UprightLabel(double height_m) { return height_m >= kWallHeight_m ? "wall" : "obstacle"; }

/// Ground axes of something that points along yaw: x ahead, y left, z up.
Eigen::Isometry3d GroundFrame(const Eigen::Vector3d& origin, double yaw_rad) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = origin;
  T.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T;
}

/// Corners given in a frame, in the world.
Ring Placed(const Eigen::Isometry3d& T_world_frame, const std::vector<Eigen::Vector3d>& corners) {
  Ring ring;
  for (const Eigen::Vector3d& corner : corners) ring.push_back(T_world_frame * corner);
  return ring;
}

/// An upright rectangle between two points of the ground, seen from the right of the way from a to b.
Ring Upright(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double height_m) {
  const Eigen::Vector3d up(0, 0, height_m);
  return {a, b, b + up, a + up};
}

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

Surface& SceneBuilder::Add(const std::string& name, const std::string& label, const Ring& outline,
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
  Add(s.name, s.label, ring, material);
}

void SceneBuilder::AddWall(const WallSpec& s, int material) {
  const Eigen::Vector2d along2 = (s.to - s.from).normalized();
  const Eigen::Vector3d along(along2.x(), along2.y(), 0.0);
  const Eigen::Vector3d left(-along.y(), along.x(), 0.0);
  const double length = (s.to - s.from).norm();
  const auto face = [&](const Eigen::Vector3d& foot, bool behind) {
    const auto rectangle = [&](double from, double to, double bottom, double top) {
      // Seen from the left, the way from `from` to `to` runs to the left.
      const double first = behind ? from : to;
      const double last = behind ? to : from;
      return Ring{foot + first * along + bottom * Eigen::Vector3d::UnitZ(),
                  foot + last * along + bottom * Eigen::Vector3d::UnitZ(),
                  foot + last * along + top * Eigen::Vector3d::UnitZ(),
                  foot + first * along + top * Eigen::Vector3d::UnitZ()};
    };
    Surface& wall =
        Add(behind ? s.name + " back" : s.name, s.label, rectangle(0.0, length, 0.0, s.height_m), material);
    if (s.openings.empty()) return;
    // Cut along all edges of all openings; what lies in none is wall.
    std::vector<double> cuts_along{0.0, length};
    std::vector<double> cuts_up{0.0, s.height_m};
    for (const WallSpec::Opening& o : s.openings) {
      cuts_along.insert(cuts_along.end(), {o.from_m, o.to_m});
      cuts_up.insert(cuts_up.end(), {o.bottom_m, o.top_m});
      const bool at_edge = o.bottom_m <= 0.0 || o.top_m >= s.height_m || o.from_m <= 0.0 || o.to_m >= length;
      if (!at_edge) wall.holes_world.push_back(rectangle(o.from_m, o.to_m, o.bottom_m, o.top_m));
    }
    std::sort(cuts_along.begin(), cuts_along.end());
    std::sort(cuts_up.begin(), cuts_up.end());
    wall.pieces.clear();
    for (std::size_t i = 0; i + 1 < cuts_along.size(); ++i) {
      for (std::size_t j = 0; j + 1 < cuts_up.size(); ++j) {
        if (cuts_along[i + 1] - cuts_along[i] < 1e-9 || cuts_up[j + 1] - cuts_up[j] < 1e-9) continue;
        const double u = 0.5 * (cuts_along[i] + cuts_along[i + 1]);
        const double v = 0.5 * (cuts_up[j] + cuts_up[j + 1]);
        const bool open = std::any_of(s.openings.begin(), s.openings.end(), [&](const WallSpec::Opening& o) {
          return o.from_m < u && u < o.to_m && o.bottom_m < v && v < o.top_m;
        });
        if (!open)
          wall.pieces.push_back(rectangle(cuts_along[i], cuts_along[i + 1], cuts_up[j], cuts_up[j + 1]));
      }
    }
    // Doors reach the floor: they are part of the outline, cut from its foot from left to right.
    std::vector<WallSpec::Opening> doors;
    std::copy_if(s.openings.begin(), s.openings.end(), std::back_inserter(doors),
                 [](const WallSpec::Opening& o) { return o.bottom_m <= 0.0; });
    std::sort(doors.begin(), doors.end(),
              [](const WallSpec::Opening& a, const WallSpec::Opening& b) { return a.from_m < b.from_m; });
    if (doors.empty()) return;
    Ring outline{foot};
    for (const WallSpec::Opening& door : doors) {
      const Eigen::Vector3d up = door.top_m * Eigen::Vector3d::UnitZ();
      outline.insert(outline.end(), {foot + door.from_m * along, foot + door.from_m * along + up,
                                     foot + door.to_m * along + up, foot + door.to_m * along});
    }
    outline.insert(outline.end(),
                   {foot + length * along, foot + length * along + s.height_m * Eigen::Vector3d::UnitZ(),
                    foot + s.height_m * Eigen::Vector3d::UnitZ()});
    if (!behind) std::reverse(outline.begin(), outline.end());
    wall.outline_world = outline;
  };
  const Eigen::Vector3d foot(s.from.x(), s.from.y(), s.z_m);
  face(foot, false);
  if (s.thickness_m <= 0.0) return;
  const Eigen::Vector3d back = foot - s.thickness_m * left;
  face(back, true);
  const Eigen::Vector3d end = foot + length * along;
  const Eigen::Vector3d back_end = back + length * along;
  const Eigen::Vector3d up(0, 0, s.height_m);
  const auto trim = [&](const std::string& what, const Ring& ring) {
    Surface& surface = Add(s.name + " " + what, s.label, ring, material);
    surface.detail = true;
  };
  trim("start", Upright(foot, back, s.height_m));
  trim("end", Upright(back_end, end, s.height_m));
  trim("top", {foot + up, back + up, back_end + up, end + up});
  for (const WallSpec::Opening& o : s.openings) {
    const Eigen::Vector3d low(0, 0, o.bottom_m);
    const Eigen::Vector3d high(0, 0, o.top_m);
    const double height = o.top_m - o.bottom_m;
    trim("reveal", Upright(back + o.from_m * along + low, foot + o.from_m * along + low, height));
    trim("reveal", Upright(foot + o.to_m * along + low, back + o.to_m * along + low, height));
    trim("lintel", {back + o.from_m * along + high, foot + o.from_m * along + high,
                    foot + o.to_m * along + high, back + o.to_m * along + high});
    if (o.bottom_m > 0.0) {
      trim("sill", {foot + o.from_m * along + low, back + o.from_m * along + low, back + o.to_m * along + low,
                    foot + o.to_m * along + low});
    }
  }
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
    Surface& surface = Add(s.name + "/" + which, label, Placed(T, corners), material);
    surface.detail = s.detail;
  };
  face("top", s.top_label,
       {{-h.x(), -h.y(), top}, {h.x(), -h.y(), top}, {h.x(), h.y(), top}, {-h.x(), h.y(), top}});
  face("-y", side, {{-h.x(), -h.y(), 0}, {h.x(), -h.y(), 0}, {h.x(), -h.y(), top}, {-h.x(), -h.y(), top}});
  face("+x", side, {{h.x(), -h.y(), 0}, {h.x(), h.y(), 0}, {h.x(), h.y(), top}, {h.x(), -h.y(), top}});
  face("+y", side, {{h.x(), h.y(), 0}, {-h.x(), h.y(), 0}, {-h.x(), h.y(), top}, {h.x(), h.y(), top}});
  face("-x", side, {{-h.x(), h.y(), 0}, {-h.x(), -h.y(), 0}, {-h.x(), -h.y(), top}, {-h.x(), h.y(), top}});
  if (s.tilt_rad == 0.0) {
    footprints_.push_back(
        Placed(T, {{-h.x(), -h.y(), 0}, {h.x(), -h.y(), 0}, {h.x(), h.y(), 0}, {-h.x(), h.y(), 0}}));
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
  Surface& surface = Add(s.name, s.label, {s.corners.begin(), s.corners.end()}, material);
  surface.detail = s.detail;
}

void SceneBuilder::AddStaircase(const StaircaseSpec& s, int material, int riser_material) {
  const Eigen::Isometry3d T = GroundFrame(s.foot, s.yaw_rad);
  const double half = 0.5 * s.width_m;
  const int n = s.num_risers;
  SceneStaircase stairs;
  stairs.truth.id = static_cast<int>(scene_.staircases.size()) + 1;
  const auto place = [&](const std::string& what, int step, const std::string& label, bool detail,
                         const std::vector<Eigen::Vector3d>& corners, int of_material) -> Surface& {
    Surface& surface =
        Add(s.name + "/" + what + std::to_string(step), label, Placed(T, corners), of_material);
    surface.detail = detail;
    return surface;
  };
  const bool slabs = s.open_risers || s.nosing_m > 0.0;
  const auto upright = [&](double x, double bottom, double top) {  // seen from below the stairs
    return std::vector<Eigen::Vector3d>{
        {x, half, bottom}, {x, -half, bottom}, {x, -half, top}, {x, half, top}};
  };
  for (int i = 1; i <= n; ++i) {
    const double run = (i - 1) * s.tread_m;
    const double low = (i - 1) * s.riser_m;
    const double high = i * s.riser_m;
    const bool last = i == n;
    if (!s.open_risers) {
      Surface& riser = place("riser", i, "stair_riser", false,
                             upright(run, low, slabs ? high - s.slab_m : high), riser_material);
      riser.staircase_id = stairs.truth.id;
      riser.step_index = i;
    }
    const double front = run - s.nosing_m;
    if (slabs) {
      // The front of the slab is the upright part of an open step's edge, too thin to be asked for.
      Surface& edge = place("edge", i, "stair_riser", true, upright(front, high - s.slab_m, high), material);
      edge.staircase_id = stairs.truth.id;
      edge.step_index = i;
      const double back = s.open_risers ? (last ? run : run + s.tread_m) : run;
      if (back - front > 1e-6) {
        place("underside", i, "other", true,
              {{front, half, high - s.slab_m},
               {back, half, high - s.slab_m},
               {back, -half, high - s.slab_m},
               {front, -half, high - s.slab_m}},
              material);
      }
    }
    if (last) {
      // The lip over the last riser belongs to what follows.
      if (s.nosing_m > 0.0 && s.landing_m <= 0.0) {
        place("lip", i, "walkway", true,
              {{front, -half, high}, {run, -half, high}, {run, half, high}, {front, half, high}}, material);
      }
      continue;
    }
    // Behind a riser the tread goes on under nothing: it ends at the next riser. Open treads overlap by
    // nothing.
    const double back = run + s.tread_m;
    Surface& tread =
        place("tread", i, "stair_tread", false,
              {{front, -half, high}, {back, -half, high}, {back, half, high}, {front, half, high}}, material);
    tread.staircase_id = stairs.truth.id;
    tread.step_index = i;
    if (s.open_risers) {
      place("back", i, "other", true,
            {{back, -half, high - s.slab_m},
             {back, half, high - s.slab_m},
             {back, half, high},
             {back, -half, high}},
            material);
      for (const double side : {half, -half}) {
        std::vector<Eigen::Vector3d> strip{{front, side, high - s.slab_m},
                                           {back, side, high - s.slab_m},
                                           {back, side, high},
                                           {front, side, high}};
        if (side > 0.0) std::reverse(strip.begin(), strip.end());
        place(side > 0.0 ? "left" : "right", i, "other", true, strip, material);
      }
    }
  }
  const double head = (n - 1) * s.tread_m;
  const double rise = n * s.riser_m;
  const double tail = head + s.landing_m;
  if (s.landing_m > 0.0) {
    const double front = head - s.nosing_m;
    Add(s.name + "/landing", "walkway",
        Placed(T, {{front, -half, rise}, {tail, -half, rise}, {tail, half, rise}, {front, half, rise}}),
        material);
    Add(s.name + "/back", UprightLabel(rise),
        Placed(T, {{tail, -half, 0}, {tail, half, 0}, {tail, half, rise}, {tail, -half, rise}}),
        riser_material);
    if (s.open_risers) {
      Add(s.name + "/landing front", UprightLabel(rise), Placed(T, upright(head, 0.0, rise - s.slab_m)),
          riser_material);
    }
  }
  const bool solid = !s.open_risers;
  if (s.sides && (solid || s.landing_m > 0.0)) {
    for (const double side : {half, -half}) {
      // The profile of the flight, from its foot up, along the landing and back along the ground.
      std::vector<Eigen::Vector3d> profile;
      std::vector<std::vector<Eigen::Vector3d>> columns;
      const auto column = [&](double from, double to, double height) {
        profile.insert(profile.end(), {{from, side, height}, {to, side, height}});
        columns.push_back({{from, side, 0}, {to, side, 0}, {to, side, height}, {from, side, height}});
      };
      profile.push_back({solid ? 0.0 : head, side, 0});
      if (solid) {
        for (int i = 1; i < n; ++i) column((i - 1) * s.tread_m, i * s.tread_m, i * s.riser_m);
      }
      if (s.landing_m > 0.0) column(head, tail, rise);
      profile.push_back({profile.back().x(), side, 0});
      std::reverse(profile.begin(), profile.end());  // now counter-clockwise from the right of the stairs
      if (side > 0.0) {
        std::reverse(profile.begin(), profile.end());
        for (auto& corners : columns) std::reverse(corners.begin(), corners.end());
      }
      Surface& face = Add(s.name + (side > 0.0 ? "/side left" : "/side right"), UprightLabel(rise),
                          Placed(T, profile), riser_material);
      face.pieces.clear();
      for (const auto& corners : columns) face.pieces.push_back(Placed(T, corners));
    }
  }
  const double foot_end = s.landing_m > 0.0 ? tail : head;
  if (solid) {
    footprints_.push_back(
        Placed(T, {{0, -half, 0}, {foot_end, -half, 0}, {foot_end, half, 0}, {0, half, 0}}));
  } else if (s.landing_m > 0.0) {
    footprints_.push_back(Placed(T, {{head, -half, 0}, {tail, -half, 0}, {tail, half, 0}, {head, half, 0}}));
  }

  stairs.truth.num_risers = n;
  stairs.truth.num_treads = n - 1;
  stairs.truth.riser_m = s.riser_m;
  stairs.truth.tread_m = s.tread_m;
  stairs.truth.width_m = s.width_m;
  stairs.truth.riser_heights_m.assign(static_cast<std::size_t>(n), s.riser_m);
  stairs.truth.tread_depths_m.assign(static_cast<std::size_t>(n - 1), s.tread_m);
  stairs.truth.direction_up_world = T.linear().col(0);
  stairs.open_risers = s.open_risers;
  stairs.truth.foot_edge_world = {T * Eigen::Vector3d(0, half, 0), T * Eigen::Vector3d(0, -half, 0)};
  stairs.truth.head_edge_world = {T * Eigen::Vector3d(head, half, rise),
                                  T * Eigen::Vector3d(head, -half, rise)};
  scene_.staircases.push_back(stairs);
}

void SceneBuilder::AddSpiral(const SpiralSpec& s, int material, int riser_material) {
  const double turn = s.turn_per_step_rad;
  const int n = s.num_risers;
  SceneStaircase stairs;
  stairs.truth.id = static_cast<int>(scene_.staircases.size()) + 1;
  const auto at = [&](double radius, double step, double height) {  // on the ray of riser step + 1
    const double angle = s.start_rad + step * turn;
    return Eigen::Vector3d(s.axis_foot +
                           Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), height));
  };
  const auto add = [&](const std::string& what, int step, const std::string& label, Ring ring,
                       int of_material) -> Surface& {
    if (turn < 0.0) std::reverse(ring.begin(), ring.end());
    return Add(s.name + "/" + what + std::to_string(step), label, ring, of_material);
  };
  for (int i = 1; i <= n; ++i) {
    const double low = (i - 1) * s.riser_m;
    const double high = i * s.riser_m;
    Surface& riser = add("riser", i, "stair_riser",
                         {at(s.inner_m, i - 1, low), at(s.outer_m, i - 1, low), at(s.outer_m, i - 1, high),
                          at(s.inner_m, i - 1, high)},
                         riser_material);
    riser.staircase_id = stairs.truth.id;
    riser.step_index = i;
    if (i == n) break;
    Surface& tread = add("tread", i, "stair_tread",
                         {at(s.inner_m, i - 1, high), at(s.outer_m, i - 1, high), at(s.outer_m, i, high),
                          at(s.inner_m, i, high)},
                         material);
    tread.staircase_id = stairs.truth.id;
    tread.step_index = i;
    add("outside", i, UprightLabel(high),
        {at(s.outer_m, i - 1, 0), at(s.outer_m, i, 0), at(s.outer_m, i, high), at(s.outer_m, i - 1, high)},
        riser_material);
  }
  // The landing goes on from the last riser in wedges of one plane.
  const double rise = n * s.riser_m;
  const int wedges = std::max(1, static_cast<int>(std::lround(s.landing_rad / std::abs(turn))));
  const double wedge = s.landing_rad / wedges / std::abs(turn);  // in steps
  Ring outline;
  std::vector<Ring> pieces;
  for (int i = 0; i <= wedges; ++i) outline.push_back(at(s.outer_m, n - 1 + i * wedge, rise));
  for (int i = wedges; i >= 0; --i) outline.push_back(at(s.inner_m, n - 1 + i * wedge, rise));
  Surface& landing = add("landing", n, "walkway", outline, material);
  for (int i = 0; i < wedges; ++i) {
    Ring piece{at(s.inner_m, n - 1 + i * wedge, rise), at(s.outer_m, n - 1 + i * wedge, rise),
               at(s.outer_m, n - 1 + (i + 1) * wedge, rise), at(s.inner_m, n - 1 + (i + 1) * wedge, rise)};
    if (turn < 0.0) std::reverse(piece.begin(), piece.end());
    pieces.push_back(piece);
  }
  landing.pieces = pieces;
  for (int i = 0; i < wedges; ++i) {
    const double from = n - 1 + i * wedge;
    const double to = from + wedge;
    add("outside", n + i, UprightLabel(rise),
        {at(s.outer_m, from, 0), at(s.outer_m, to, 0), at(s.outer_m, to, rise), at(s.outer_m, from, rise)},
        riser_material);
  }
  const double end = n - 1 + s.landing_rad / std::abs(turn);
  add("end", n, UprightLabel(rise),
      {at(s.outer_m, end, 0), at(s.inner_m, end, 0), at(s.inner_m, end, rise), at(s.outer_m, end, rise)},
      riser_material);
  // The column in the middle, with a corner on every riser.
  const double column_top = rise + 1.0;
  const int corners = std::max(3, static_cast<int>(std::lround(2.0 * std::numbers::pi / std::abs(turn))));
  for (int i = 0; i < corners; ++i) {
    Surface& face = add("column", i, "wall",
                        {at(s.inner_m, i, 0), at(s.inner_m, i + 1, 0), at(s.inner_m, i + 1, column_top),
                         at(s.inner_m, i, column_top)},
                        material);
    face.detail = 2.0 * s.inner_m * std::sin(0.5 * std::abs(turn)) < 0.1;
  }
  // On the ground it leaves out the way round it: along the outside, and back around the column.
  Ring footprint;
  for (int i = 0; i < n; ++i) footprint.push_back(at(s.outer_m, i, 0));
  for (int i = 1; i <= wedges; ++i) footprint.push_back(at(s.outer_m, n - 1 + i * wedge, 0));
  footprint.push_back(at(s.inner_m, end, 0));
  for (int i = static_cast<int>(std::floor(end)) + 1; i < corners; ++i)
    footprint.push_back(at(s.inner_m, i, 0));
  footprint.push_back(at(s.inner_m, 0, 0));
  if (turn < 0.0) std::reverse(footprint.begin(), footprint.end());
  footprints_.push_back(footprint);
  const double middle = 0.5 * (s.inner_m + s.outer_m);
  stairs.truth.num_risers = n;
  stairs.truth.num_treads = n - 1;
  stairs.truth.riser_m = s.riser_m;
  stairs.truth.tread_m = middle * std::abs(turn);
  stairs.truth.width_m = s.outer_m - s.inner_m;
  const double way = s.start_rad + (turn > 0.0 ? 0.5 : -0.5) * std::numbers::pi;
  stairs.truth.riser_heights_m.assign(static_cast<std::size_t>(n), s.riser_m);
  stairs.truth.tread_depths_m.assign(static_cast<std::size_t>(n - 1), stairs.truth.tread_m);
  stairs.truth.direction_up_world = Eigen::Vector3d(std::cos(way), std::sin(way), 0.0);
  stairs.turn_per_step_rad = turn;
  const double left = turn > 0.0 ? s.inner_m : s.outer_m;
  const double right = turn > 0.0 ? s.outer_m : s.inner_m;
  stairs.truth.foot_edge_world = {at(left, 0, 0), at(right, 0, 0)};
  stairs.truth.head_edge_world = {at(left, n - 1, rise), at(right, n - 1, rise)};
  scene_.staircases.push_back(stairs);
}

void SceneBuilder::AddRamp(const RampSpec& s, int material) {
  const Eigen::Isometry3d T = GroundFrame(s.foot, s.yaw_rad);
  const double half = 0.5 * s.width_m;
  const double tail = s.length_m + s.landing_m;
  const bool gentle = std::atan2(s.rise_m, s.length_m) <= kWalkwaySlope_rad;
  Add(s.name, gentle ? "walkway" : "ramp",
      Placed(T, {{0, -half, 0}, {s.length_m, -half, s.rise_m}, {s.length_m, half, s.rise_m}, {0, half, 0}}),
      material);
  if (s.landing_m > 0.0) {
    Add(s.name + "/landing", "walkway",
        Placed(T, {{s.length_m, -half, s.rise_m},
                   {tail, -half, s.rise_m},
                   {tail, half, s.rise_m},
                   {s.length_m, half, s.rise_m}}),
        material);
  }
  Add(s.name + "/back", UprightLabel(s.rise_m),
      Placed(T, {{tail, -half, 0}, {tail, half, 0}, {tail, half, s.rise_m}, {tail, -half, s.rise_m}}),
      material);
  for (const double side : {half, -half}) {
    std::vector<Eigen::Vector3d> profile{{0, side, 0}, {tail, side, 0}, {tail, side, s.rise_m}};
    if (s.landing_m > 0.0) profile.push_back({s.length_m, side, s.rise_m});
    if (side > 0.0) std::reverse(profile.begin(), profile.end());
    Add(s.name + (side > 0.0 ? "/side left" : "/side right"), UprightLabel(s.rise_m), Placed(T, profile),
        material);
  }
  footprints_.push_back(Placed(T, {{0, -half, 0}, {tail, -half, 0}, {tail, half, 0}, {0, half, 0}}));
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
