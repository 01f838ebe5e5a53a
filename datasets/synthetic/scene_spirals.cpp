// SPDX-License-Identifier: BSD-3-Clause
// Spiral stairs: steps about an upright axis.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "datasets/synthetic/scene_builder.h"
#include "datasets/synthetic/scene_solids.h"

namespace terrace::synthetic {
namespace {

/// Makes the planes of one spiral. Places about the axis are told in steps: riser i stands on the ray i - 1.
class SpiralMaker {
 public:
  SpiralMaker(const SpiralSpec& spec, int material, int riser_material, int id, SceneBuilder* builder)
      : spec_(spec),
        material_(material),
        riser_material_(riser_material),
        id_(id),
        builder_(*builder),
        rise_(spec.num_risers * spec.riser_m),
        head_(spec.num_risers - 1),
        turn_(std::abs(spec.turn_per_step_rad)),
        num_wedges_(std::max(1, static_cast<int>(std::lround(spec.landing_rad / turn_)))),
        wedge_(spec.landing_rad / num_wedges_ / turn_),
        end_(head_ + spec.landing_rad / turn_),
        num_corners_(std::max(3, static_cast<int>(std::lround(2.0 * std::numbers::pi / turn_)))) {}

  SceneStaircase Make() {
    for (int i = 1; i <= spec_.num_risers; ++i) MakeStep(i);
    MakeLanding();
    MakeColumn();
    LeaveOutOfFloor();
    return Truth();
  }

 private:
  Eigen::Vector3d At(double radius, double step, double height) const {
    const double angle = spec_.start_rad + step * spec_.turn_per_step_rad;
    return spec_.axis_foot + Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle), height);
  }
  Eigen::Vector3d Inner(double step, double height) const { return At(spec_.inner_m, step, height); }
  Eigen::Vector3d Outer(double step, double height) const { return At(spec_.outer_m, step, height); }

  /// Rings are given as those of a spiral that turns left going up.
  Ring Turned(Ring ring) const {
    if (spec_.turn_per_step_rad < 0.0) std::reverse(ring.begin(), ring.end());
    return ring;
  }
  Surface& Place(const std::string& what, int step, const std::string& label, const Ring& ring,
                 int material) {
    return builder_.AddFace(spec_.name + "/" + what + std::to_string(step), label, Turned(ring), material);
  }
  Ring Outside(double from, double to, double height) const {
    return {Outer(from, 0), Outer(to, 0), Outer(to, height), Outer(from, height)};
  }

  void MakeStep(int i) {
    const double low = (i - 1) * spec_.riser_m;
    const double high = i * spec_.riser_m;
    Surface& riser = Place("riser", i, "stair_riser",
                           {Inner(i - 1, low), Outer(i - 1, low), Outer(i - 1, high), Inner(i - 1, high)},
                           riser_material_);
    riser.staircase_id = id_;
    riser.step_index = i;
    if (i == spec_.num_risers) return;
    Surface& tread =
        Place("tread", i, "stair_tread",
              {Inner(i - 1, high), Outer(i - 1, high), Outer(i, high), Inner(i, high)}, material_);
    tread.staircase_id = id_;
    tread.step_index = i;
    Place("outside", i, UprightLabel(high), Outside(i - 1, i, high), riser_material_);
  }

  /// It goes on from the last riser in wedges of one plane.
  void MakeLanding() {
    Ring outline;
    for (int i = 0; i <= num_wedges_; ++i) outline.push_back(Outer(head_ + i * wedge_, rise_));
    for (int i = num_wedges_; i >= 0; --i) outline.push_back(Inner(head_ + i * wedge_, rise_));
    Surface& landing = Place("landing", spec_.num_risers, "walkway", outline, material_);
    landing.pieces.clear();
    for (int i = 0; i < num_wedges_; ++i) {
      const double from = head_ + i * wedge_;
      const double to = head_ + (i + 1) * wedge_;
      landing.pieces.push_back(
          Turned({Inner(from, rise_), Outer(from, rise_), Outer(to, rise_), Inner(to, rise_)}));
    }
    for (int i = 0; i < num_wedges_; ++i) {
      const double from = head_ + i * wedge_;
      Place("outside", spec_.num_risers + i, UprightLabel(rise_), Outside(from, from + wedge_, rise_),
            riser_material_);
    }
    Place("end", spec_.num_risers, UprightLabel(rise_),
          {Outer(end_, 0), Inner(end_, 0), Inner(end_, rise_), Outer(end_, rise_)}, riser_material_);
  }

  /// In the middle, with a corner on every riser.
  void MakeColumn() {
    const double top = rise_ + 1.0;
    for (int i = 0; i < num_corners_; ++i) {
      Surface& face = Place("column", i, "wall",
                            {Inner(i, 0), Inner(i + 1, 0), Inner(i + 1, top), Inner(i, top)}, material_);
      face.detail = 2.0 * spec_.inner_m * std::sin(0.5 * turn_) < 0.1;
    }
  }

  /// The way round it on the ground: along the outside, and back around the column.
  void LeaveOutOfFloor() {
    Ring footprint;
    for (int i = 0; i < spec_.num_risers; ++i) footprint.push_back(Outer(i, 0));
    for (int i = 1; i <= num_wedges_; ++i) footprint.push_back(Outer(head_ + i * wedge_, 0));
    footprint.push_back(Inner(end_, 0));
    for (int i = static_cast<int>(std::floor(end_)) + 1; i < num_corners_; ++i)
      footprint.push_back(Inner(i, 0));
    footprint.push_back(Inner(0, 0));
    builder_.AddFootprint(Turned(footprint));
  }

  SceneStaircase Truth() const {
    const bool turns_left = spec_.turn_per_step_rad > 0.0;
    SceneStaircase stairs;
    stairs.truth.id = id_;
    stairs.truth.num_risers = spec_.num_risers;
    stairs.truth.num_treads = spec_.num_risers - 1;
    stairs.truth.riser_m = spec_.riser_m;
    stairs.truth.tread_m = 0.5 * (spec_.inner_m + spec_.outer_m) * turn_;
    stairs.truth.width_m = spec_.outer_m - spec_.inner_m;
    stairs.truth.riser_heights_m.assign(static_cast<std::size_t>(spec_.num_risers), spec_.riser_m);
    stairs.truth.tread_depths_m.assign(static_cast<std::size_t>(spec_.num_risers - 1), stairs.truth.tread_m);
    const double way = spec_.start_rad + (turns_left ? 0.5 : -0.5) * std::numbers::pi;
    stairs.truth.direction_up_world = Eigen::Vector3d(std::cos(way), std::sin(way), 0.0);
    stairs.turn_per_step_rad = spec_.turn_per_step_rad;
    const double left = turns_left ? spec_.inner_m : spec_.outer_m;
    const double right = turns_left ? spec_.outer_m : spec_.inner_m;
    stairs.truth.foot_edge_world = {At(left, 0, 0), At(right, 0, 0)};
    stairs.truth.head_edge_world = {At(left, head_, rise_), At(right, head_, rise_)};
    return stairs;
  }

  const SpiralSpec& spec_;
  const int material_, riser_material_;
  const int id_;  ///< of the staircase
  SceneBuilder& builder_;
  const double rise_;      ///< height of the landing [m]
  const double head_;      ///< where the last riser stands, in steps
  const double turn_;      ///< per step, without its sign [rad]
  const int num_wedges_;   ///< of the landing
  const double wedge_;     ///< in steps
  const double end_;       ///< of the landing, in steps
  const int num_corners_;  ///< of the column
};

}  // namespace

void SceneBuilder::AddSpiral(const SpiralSpec& spec, int material, int riser_material) {
  const int id = static_cast<int>(scene_.staircases.size()) + 1;
  scene_.staircases.push_back(SpiralMaker(spec, material, riser_material, id, this).Make());
}

}  // namespace terrace::synthetic
