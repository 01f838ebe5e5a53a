// SPDX-License-Identifier: BSD-3-Clause
// Families of places without stairs.
#include <cmath>
#include <numbers>

#include "datasets/synthetic/place.h"

namespace terrace::synthetic {
namespace {

constexpr double kGroundDegree = std::numbers::pi / 180.0;
constexpr double kWallFrom_m = 1.0;  ///< faces of this height are walls

const char* FaceLabel(double height_m) { return height_m >= kWallFrom_m ? "wall" : "obstacle"; }

/// A board along a wall of the room, from `corner` on towards x: a top that nothing stands under, with a thin
/// front.
void AddShelf(Place& place, const Eigen::Vector3d& corner, double length_m, double depth_m) {
  constexpr double kThick_m = 0.03;
  const bool left_wall = corner.y() > 0.0;
  const double front_y = left_wall ? corner.y() - depth_m : corner.y() + depth_m;
  const Eigen::Vector3d front(corner.x(), front_y, corner.z()), along(length_m, 0.0, 0.0);
  const Eigen::Vector3d below(0.0, 0.0, -kThick_m);
  QuadSpec top, face;
  top.name = "shelf";
  top.label = "level";
  top.corners = {front, front + along, corner + along, corner};
  face.name = "shelf front";
  face.detail = true;
  face.corners = {front + below, front + along + below, front + along, front};
  if (!left_wall) {
    top.corners = {corner, corner + along, front + along, front};
    face.corners = {front + along + below, front + below, front, front + along};
  }
  place.build().AddQuad(top, place.material().things);
  place.build().AddQuad(face, place.material().things);
}

}  // namespace

void DrawDrop(Place& place) {
  const double edge = place.Draw(2.8, 3.4), skew = std::tan(place.Draw(-25.0, 25.0) * kGroundDegree);
  const bool deep = place.Chance(0.3);
  const double depth = deep ? place.Draw(2.5, 4.0) : place.Draw(0.26, 1.2);
  constexpr double kHalf_m = 4.0, kFar_m = 12.0;
  const double right = edge - kHalf_m * skew, left = edge + kHalf_m * skew;
  QuadSpec upper;
  upper.name = "upper ground";
  upper.label = "walkway";
  upper.corners = {Eigen::Vector3d(-2.5, -kHalf_m, 0.0),
                   {right, -kHalf_m, 0.0},
                   {left, kHalf_m, 0.0},
                   {-2.5, kHalf_m, 0.0}};
  place.build().AddQuad(upper, place.material().ground);
  QuadSpec face;
  face.name = "face";
  face.label = FaceLabel(depth);
  face.corners = {Eigen::Vector3d(right, -kHalf_m, -depth),
                  {left, kHalf_m, -depth},
                  {left, kHalf_m, 0.0},
                  {right, -kHalf_m, 0.0}};
  place.build().AddQuad(face, place.material().risers);
  // Farther down than the robot can step: it is never reached.
  QuadSpec lower;
  lower.name = "lower ground";
  lower.label = "level";
  lower.corners = {Eigen::Vector3d(right, -kHalf_m, -depth),
                   {kFar_m, -kHalf_m, -depth},
                   {kFar_m, kHalf_m, -depth},
                   {left, kHalf_m, -depth}};
  place.build().AddQuad(lower, place.Chance(0.5) ? place.material().ground : place.material().steps);
  if (place.Chance(0.5)) {
    place.Room({{-2.5, -kHalf_m}, {kFar_m, kHalf_m}}, -depth, depth + 3.5);
    place.Lamps({{0.5, 0.0, 0.6}, {edge, 1.0, 0.8}, {edge + 2.5, -0.5, 0.4}});
  } else {
    place.Sun();
  }
  const double side = place.DrawSign(), along = side * skew;
  place.Walk({{0.0, 0.0},
              {edge - 1.3, 0.0},
              {edge - 0.8 + 0.3 * along, 0.3 * side},
              {edge - 0.7 + along, side},
              {edge - 0.7 + 2.5 * along, 2.5 * side}});
  place.Things({{0.3, -2.5}, {edge - 1.9, 2.5}}, 0.0, 0, 4, 0.35);
}

void DrawRamp(Place& place) {
  RampSpec ramp;
  ramp.length_m = place.Draw(1.4, 2.8);
  const double slope = place.Chance(0.15) ? place.Draw(4.0, 7.0) : place.Draw(9.5, 26.0);
  ramp.rise_m = ramp.length_m * std::tan(slope * kGroundDegree);
  ramp.width_m = place.Draw(1.0, 2.2);
  ramp.landing_m = place.Draw(1.0, 1.8);
  ramp.yaw_rad = place.Draw(-22.0, 22.0) * kGroundDegree;
  ramp.foot = {place.Draw(2.6, 3.4), place.Draw(-0.3, 0.3), 0.0};
  place.build().AddRamp(ramp, place.material().steps);
  const Area ground{{-2.5, -4.5}, {10.0, 4.5}};
  place.Floor("ground", ground, 0.0);
  if (place.Chance(0.5)) {
    place.Room(ground, 0.0, 3.6);
    place.Lamps({{1.0, 0.0, 0.4}, {3.5, 0.6, 0.8}, {6.0, -0.5, 1.0}});
  } else {
    place.Sun();
  }
  const Eigen::Vector2d foot = ramp.foot.head<2>(), up(std::cos(ramp.yaw_rad), std::sin(ramp.yaw_rad));
  place.Walk({{0.0, 0.0}, foot - 0.8 * up, foot + ramp.length_m * up, foot + (ramp.length_m + 0.7) * up});
  place.Things({{0.3, -2.5}, {ramp.foot.x() - 0.9, 2.5}}, 0.0, 0, 5, 0.35);
}

void DrawKerb(Place& place) {
  const double height = place.Draw(0.06, 0.17), depth = place.Draw(2.0, 3.5);
  const double yaw = place.Draw(-28.0, 28.0) * kGroundDegree, length = 12.0;
  const Eigen::Vector2d ahead(std::cos(yaw), std::sin(yaw)), left(-ahead.y(), ahead.x());
  const Eigen::Vector2d kerb = Eigen::Vector2d(place.Draw(2.2, 2.9), 0.0);
  place.Floor("road", {{-8.0, -11.0}, {12.0, 11.0}}, 0.0);
  BoxSpec pavement;
  pavement.name = "pavement";
  const Eigen::Vector2d middle = kerb + 0.5 * depth * ahead;
  pavement.base_center = {middle.x(), middle.y(), 0.0};
  pavement.size_m = {depth, length, height};
  pavement.yaw_rad = yaw;
  pavement.top_label = "walkway";
  place.build().AddBox(pavement, place.material().steps);
  if (place.Chance(0.6)) {
    const Eigen::Vector2d house = kerb + depth * ahead;
    place.Wall("house", house - 0.5 * length * left, house + 0.5 * length * left, height, 3.0);
  }
  place.Sun();
  place.Walk({{0.0, 0.0},
              kerb - 0.6 * ahead,
              kerb + 0.9 * ahead,
              kerb + 0.9 * ahead + 2.5 * (ahead + left).normalized()});
  place.Things({{0.2, -3.0}, {kerb.x() - 1.2, 3.0}}, 0.0, 0, 4, 0.35);
}

void DrawClutter(Place& place) {
  const Area room{{-1.5, -place.Draw(1.6, 2.6)}, {place.Draw(5.0, 7.0), place.Draw(1.6, 2.6)}};
  place.Floor("floor", room, 0.0);
  place.Room(room, 0.0, 2.8);
  place.Lamps({{0.5, 0.3, 0.0}, {2.8, -0.3, 0.0}, {4.8, 0.2, 0.0}});
  place.Walk({{0.0, 0.0}, {1.5, place.Draw(-0.4, 0.4)}, {2.8, place.Draw(-0.4, 0.4)}, {4.3, 0.0}});
  const int shelves = place.DrawCount(0, 2);
  for (int i = 0; i < shelves; ++i) {
    // One a wall, with nothing below.
    const double wall_y = i == 0 ? room.max.y() : room.min.y();
    const double from_x = place.Draw(0.8, 2.5), length_m = place.Draw(0.6, 1.4);
    const double z_m = place.Draw(0.35, 0.8), depth_m = place.Draw(0.2, 0.35);
    AddShelf(place, {from_x, wall_y, z_m}, length_m, depth_m);
    place.Reserve({from_x + 0.5 * length_m, wall_y}, 0.5 * length_m + 0.1);
  }
  place.Things({{0.4, room.min.y()}, {room.max.x(), room.max.y()}}, 0.0, 5, 12, 0.22);
}

}  // namespace terrace::synthetic
