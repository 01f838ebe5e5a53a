// SPDX-License-Identifier: BSD-3-Clause
// Families of places with stairs.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "datasets/synthetic/place.h"

namespace terrace::synthetic {
namespace {

constexpr double kStairsDegree = std::numbers::pi / 180.0;
constexpr double kStorey_m = 2.6;
constexpr double kBehind_m = -1.5;  ///< where the ground begins, behind the robot

StaircaseSpec DrawFlight(Place& place, int least_risers, int most_risers) {
  StaircaseSpec flight;
  flight.num_risers = place.DrawCount(least_risers, most_risers);
  flight.riser_m = place.Draw(0.10, 0.195);
  flight.tread_m = place.Draw(0.25, 0.36);
  if (place.Chance(0.3)) {
    flight.nosing_m = place.Draw(0.01, 0.03);
    flight.slab_m = place.Draw(0.025, 0.045);
  }
  return flight;
}

double Run(const StaircaseSpec& flight) { return (flight.num_risers - 1) * flight.tread_m; }
double Rise(const StaircaseSpec& flight) { return flight.num_risers * flight.riser_m; }

/// Straight on for a while, then towards a flight and up its middle.
std::vector<Eigen::Vector2d> PathUp(const StaircaseSpec& flight, double beyond_m) {
  const Eigen::Vector2d foot = flight.foot.head<2>();
  const Eigen::Vector2d up(std::cos(flight.yaw_rad), std::sin(flight.yaw_rad));
  return {Eigen::Vector2d(0.0, 0.0), foot - 0.8 * up, foot + Run(flight) * up,
          foot + (Run(flight) + beyond_m) * up};
}

void LightRoomOrYard(Place& place, const Area& area) {
  if (place.Chance(0.6)) {
    place.Room(area, 0.0, 3.8);
    const double x = area.max.x();
    place.Lamps({{0.2 * x, 0.0, 0.6}, {0.5 * x, 0.5, 0.9}, {0.8 * x, -0.5, 1.2}});
  } else {
    place.Sun();
  }
}

}  // namespace

void DrawStairsUp(Place& place) {
  const double half = place.Draw(0.8, 1.4);
  StaircaseSpec flight = DrawFlight(place, 4, 9);
  flight.foot = {place.Draw(3.0, 3.8), 0.0, 0.0};
  flight.sides = false;
  const bool narrower = place.Chance(0.5);
  const double side = narrower ? half - place.Draw(0.12, 0.3) : half;
  flight.width_m = 2.0 * side;
  const double foot = flight.foot.x(), head = foot + Run(flight), rise = Rise(flight);
  const double end = head + place.Draw(2.0, 3.2), landing_half = half + place.Draw(0.0, 0.8);
  place.build().AddStaircase(flight, place.material().steps, place.material().risers);
  place.Floor("corridor floor", {{kBehind_m, -half}, {foot, half}}, 0.0);
  place.Floor("landing", {{head, -landing_half}, {end, landing_half}}, rise);
  place.Wall("corridor left", {foot, half}, {kBehind_m, half}, 0.0, kStorey_m);
  place.Wall("corridor right", {kBehind_m, -half}, {foot, -half}, 0.0, kStorey_m);
  place.Wall("corridor back", {kBehind_m, half}, {kBehind_m, -half}, 0.0, kStorey_m);
  if (narrower) {
    place.Wall("return left", {foot, side}, {foot, half}, 0.0, kStorey_m);
    place.Wall("return right", {foot, -half}, {foot, -side}, 0.0, kStorey_m);
  }
  place.Wall("stairwell left", {head, side}, {foot, side}, 0.0, rise + kStorey_m);
  place.Wall("stairwell right", {foot, -side}, {head, -side}, 0.0, rise + kStorey_m);
  if (landing_half > side + 0.01) {
    place.Wall("landing back left", {head, landing_half}, {head, side}, rise, kStorey_m);
    place.Wall("landing back right", {head, -side}, {head, -landing_half}, rise, kStorey_m);
  }
  place.Wall("landing left", {end, landing_half}, {head, landing_half}, rise, kStorey_m);
  place.Wall("landing right", {head, -landing_half}, {end, -landing_half}, rise, kStorey_m);
  place.Wall("landing end", {end, -landing_half}, {end, landing_half}, rise, kStorey_m);
  place.Lamps({{0.8, 0.0, 0.0}, {foot - 0.6, 0.0, 0.0}, {head + 0.5, 0.0, rise}});
  place.Walk(PathUp(flight, 1.5));
  place.Things({{0.3, -half}, {foot - 0.5, half}}, 0.0, 0, 3, 0.25);
}

void DrawStairsUpFree(Place& place) {
  StaircaseSpec flight = DrawFlight(place, 3, 7);
  flight.foot = {place.Draw(3.0, 3.6), place.Draw(-0.4, 0.4), 0.0};
  flight.yaw_rad = place.Draw(-25.0, 25.0) * kStairsDegree;
  flight.width_m = place.Draw(0.9, 2.2);
  flight.landing_m = place.Draw(1.0, 2.0);
  place.build().AddStaircase(flight, place.material().steps, place.material().risers);
  const Area ground{{kBehind_m - 1.0, -4.5}, {10.0, 4.5}};
  place.Floor("ground", ground, 0.0);
  LightRoomOrYard(place, ground);
  place.Walk(PathUp(flight, 0.7));
  place.Things({{0.3, -2.5}, {flight.foot.x() - 1.0, 2.5}}, 0.0, 0, 5, 0.35);
}

void DrawStairsOpen(Place& place) {
  StaircaseSpec flight = DrawFlight(place, 4, 7);
  flight.open_risers = true;
  flight.nosing_m = 0.0;
  flight.slab_m = place.Draw(0.03, 0.05);
  flight.riser_m = place.Draw(0.14, 0.195);
  flight.foot = {place.Draw(3.0, 3.6), place.Draw(-0.3, 0.3), 0.0};
  flight.yaw_rad = place.Draw(-20.0, 20.0) * kStairsDegree;
  flight.width_m = place.Draw(0.9, 1.5);
  flight.landing_m = place.Draw(1.0, 1.8);
  place.build().AddStaircase(flight, place.material().steps, place.material().risers);
  const Area ground{{kBehind_m - 1.0, -4.5}, {10.0, 4.5}};
  place.Floor("ground", ground, 0.0);
  LightRoomOrYard(place, ground);
  place.Walk(PathUp(flight, 0.7));
  place.Things({{0.3, -2.5}, {flight.foot.x() - 1.0, 2.5}}, 0.0, 0, 4, 0.35);
}

void DrawStairsDown(Place& place) {
  StaircaseSpec flight = DrawFlight(place, 3, 8);
  const double edge = place.Draw(2.8, 3.5), foot = edge + Run(flight), low = -Rise(flight);
  flight.foot = {foot, 0.0, low};
  flight.yaw_rad = std::numbers::pi;
  const bool free = place.Chance(0.4);
  const double half = free ? place.Draw(1.5, 2.2) : place.Draw(0.7, 1.2);
  flight.width_m = free ? place.Draw(1.0, 1.8) : 2.0 * half;
  flight.sides = free;
  place.build().AddStaircase(flight, place.material().steps, place.material().risers);
  const double end = foot + 3.5;
  place.Floor("upper floor", {{kBehind_m, -half}, {edge, half}}, 0.0);
  // Beside a free flight the hall reaches to under the upper floor's edge, so that the flight stands inside.
  place.Floor("hall floor", {{free ? edge - 0.5 : foot, -half}, {end, half}}, low);
  if (free) place.Wall("face", {edge, half}, {edge, -half}, low, -low);
  place.Room({{kBehind_m, -half}, {end, half}}, low, -low + kStorey_m);
  place.Lamps({{0.5, 0.0, 0.0}, {edge, 0.2, 0.0}, {foot + 1.0, 0.0, low + 0.6}});
  place.Walk({{0.0, 0.0}, {edge - 0.8, place.Draw(-0.15, 0.15)}, {foot, 0.0}, {foot + 2.0, 0.0}});
  place.Things({{0.3, -half}, {edge - 0.6, half}}, 0.0, 0, 2, 0.3);
  place.Things({{foot + 0.8, -half}, {end, half}}, low, 0, 3, 0.35);
}

void DrawSpiral(Place& place, double side) {
  SpiralSpec spiral;
  spiral.inner_m = place.Draw(0.2, 0.4);
  spiral.outer_m = spiral.inner_m + place.Draw(0.95, 1.3);
  const double turn = 2.0 * std::numbers::pi / place.DrawCount(12, 18);
  spiral.turn_per_step_rad = side * turn;
  // Past this turn it would come round to where the robot walks in.
  constexpr double kMostTurn_rad = 190.0 * kStairsDegree;
  spiral.num_risers = std::min(place.DrawCount(6, 10), 1 + static_cast<int>(kMostTurn_rad / turn));
  spiral.riser_m = place.Draw(0.11, 0.19);
  spiral.landing_rad = place.Draw(40.0, 60.0) * kStairsDegree;
  const double middle = 0.5 * (spiral.inner_m + spiral.outer_m);
  const double foot = place.Draw(2.8, 3.4);
  spiral.axis_foot = {foot, side * middle, 0.0};
  spiral.start_rad = -0.5 * side * std::numbers::pi;
  place.build().AddSpiral(spiral, place.material().steps, place.material().risers);
  const double reach = middle + spiral.outer_m + 1.0;
  const Area ground{{kBehind_m, side > 0.0 ? -2.2 : -reach},
                    {foot + spiral.outer_m + 1.0, side > 0.0 ? reach : 2.2}};
  place.Floor("floor", ground, 0.0);
  place.Room(ground, 0.0, 4.2);
  place.Lamps({{0.5, 0.0, 0.6}, {foot - 0.3, side * 0.8, 1.6}, {foot + 0.5, side * 2.0, 1.6}});
  std::vector<Eigen::Vector2d> path{{0.0, 0.0}, {foot - 0.9, 0.0}, {foot - 0.2, 0.0}};
  const double whole = (spiral.num_risers - 1) * turn + 0.5 * spiral.landing_rad;
  for (double angle = 0.5 * turn; angle < whole; angle += turn) {
    const double at = spiral.start_rad + side * angle;
    path.push_back(spiral.axis_foot.head<2>() + middle * Eigen::Vector2d(std::cos(at), std::sin(at)));
  }
  place.Walk(path, 100);
  place.Things({{0.3, -2.0}, {foot - 1.2, 2.0}}, 0.0, 0, 3, 0.35);
}

namespace {

/// Two flights in one line, with a landing between.
void DrawStraightDogleg(Place& place, StaircaseSpec first, StaircaseSpec second, double landing_m) {
  const double half = 0.5 * first.width_m;
  const double foot = first.foot.x(), head = foot + Run(first), middle = Rise(first);
  second.foot = {head + landing_m, 0.0, middle};
  const double top = second.foot.x() + Run(second), rise = middle + Rise(second), end = top + 2.2;
  place.build().AddStaircase(first, place.material().steps, place.material().risers);
  place.build().AddStaircase(second, place.material().steps, place.material().risers);
  place.Floor("corridor floor", {{kBehind_m, -half}, {foot, half}}, 0.0);
  place.Floor("landing", {{head, -half}, {head + landing_m, half}}, middle);
  place.Floor("upper floor", {{top, -half}, {end, half}}, rise);
  place.Room({{kBehind_m, -half}, {end, half}}, 0.0, rise + kStorey_m);
  place.Lamps({{0.5, 0.0, 0.2}, {head, 0.0, middle}, {top, 0.0, rise}});
  place.Walk({{0.0, 0.0}, {foot, 0.0}, {head + 0.5 * landing_m, 0.0}, {top, 0.0}, {end - 0.6, 0.0}}, 140);
}

/// The second flight goes back beside the first, behind a wall.
void DrawTurningDogleg(Place& place, StaircaseSpec first, StaircaseSpec second, double landing_m) {
  const double side = place.DrawSign(), width = first.width_m, half = 0.5 * width;
  const double gap = place.Draw(0.1, 0.25), lane = side * (width + gap), outer = side * (1.5 * width + gap);
  const double foot = first.foot.x(), head = foot + Run(first), middle = Rise(first), end = head + landing_m;
  second.foot = {head, lane, middle};
  second.yaw_rad = std::numbers::pi;
  const double top = head - Run(second), rise = middle + Rise(second), back = top - 2.0;
  const double height = rise + kStorey_m;
  place.build().AddStaircase(first, place.material().steps, place.material().risers);
  place.build().AddStaircase(second, place.material().steps, place.material().risers);
  place.Floor("corridor floor", {{kBehind_m, -half}, {foot, half}}, 0.0);
  const double low = std::min(-side * half, outer), high = std::max(-side * half, outer);
  place.Floor("landing", {{head, low}, {end, high}}, middle);
  place.Floor("upper floor", {{back, lane - half}, {top, lane + half}}, rise);
  WallSpec between;
  between.name = "between";
  between.from = {side > 0.0 ? head : kBehind_m, side * half};
  between.to = {side > 0.0 ? kBehind_m : head, side * half};
  between.thickness_m = gap;
  between.height_m = rise + place.Draw(0.4, kStorey_m);
  place.build().AddWall(between, place.material().walls);
  // Walls in the order that shows their inner side: to the left of the way.
  const auto along = [&](const char* name, double y, double from, double to, bool seen_from_above_y) {
    if (seen_from_above_y) place.Wall(name, {from, y}, {to, y}, 0.0, height);
    if (!seen_from_above_y) place.Wall(name, {to, y}, {from, y}, 0.0, height);
  };
  along("corridor side", -side * half, kBehind_m, end, side > 0.0);
  along("upper side", outer, back, end, side < 0.0);
  place.Wall("corridor back", {kBehind_m, half}, {kBehind_m, -half}, 0.0, height);
  place.Wall("upper back", {back, lane + half}, {back, lane - half}, rise, kStorey_m);
  place.Wall("landing end", {end, low}, {end, high}, 0.0, height);
  place.Lamps({{0.5, 0.0, 0.2}, {head + 0.5, 0.5 * lane, middle}, {top, lane, rise}});
  place.Walk({{0.0, 0.0},
              {foot, 0.0},
              {head + 0.35 * landing_m, 0.05 * lane},
              {head + 0.6 * landing_m, 0.5 * lane},
              {head + 0.35 * landing_m, 0.95 * lane},
              {head - 0.4, lane},
              {top, lane},
              {back + 0.6, lane}},
             160);
}

}  // namespace

void DrawDogleg(Place& place) {
  StaircaseSpec first = DrawFlight(place, 3, 5);
  first.foot = {place.Draw(1.8, 2.3), 0.0, 0.0};
  first.width_m = place.Draw(1.0, 1.4);
  first.sides = false;
  StaircaseSpec second = first;
  second.name = "second stairs";
  second.num_risers = place.DrawCount(3, 5);
  const double landing_m = place.Draw(1.1, 1.5);
  if (place.Chance(0.4)) {
    DrawStraightDogleg(place, first, second, landing_m);
  } else {
    DrawTurningDogleg(place, first, second, landing_m);
  }
}

}  // namespace terrace::synthetic
