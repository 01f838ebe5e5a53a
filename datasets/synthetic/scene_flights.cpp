// SPDX-License-Identifier: BSD-3-Clause
// Straight flights of stairs.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "datasets/synthetic/scene_builder.h"
#include "datasets/synthetic/scene_solids.h"

namespace terrace::synthetic {
namespace {

using Corners = std::vector<Eigen::Vector3d>;

/// Makes the planes of one flight, in its own frame: x up the stairs, y left, the origin in the middle of its
/// foot edge.
class FlightMaker {
 public:
  FlightMaker(const StaircaseSpec& spec, int material, int riser_material, int id, SceneBuilder* builder)
      : spec_(spec),
        material_(material),
        riser_material_(riser_material),
        id_(id),
        builder_(*builder),
        T_world_stairs_(GroundFrame(spec.foot, spec.yaw_rad)),
        half_(0.5 * spec.width_m),
        head_((spec.num_risers - 1) * spec.tread_m),
        rise_(spec.num_risers * spec.riser_m),
        tail_(head_ + spec.landing_m) {}

  SceneStaircase Make() {
    for (int i = 1; i <= spec_.num_risers; ++i) MakeStep(i);
    if (spec_.landing_m > 0.0) MakeLanding();
    if (spec_.sides && (solid() || spec_.landing_m > 0.0)) {
      for (const double side : {half_, -half_}) MakeSide(side);
    }
    LeaveOutOfFloor();
    return Truth();
  }

 private:
  bool solid() const { return !spec_.open_risers; }
  /// Treads are slabs that show a front of their own.
  bool slabs() const { return spec_.open_risers || spec_.nosing_m > 0.0; }

  Ring InWorld(const Corners& corners) const { return Placed(T_world_stairs_, corners); }

  Surface& Place(const std::string& what, int step, const std::string& label, bool detail,
                 const Corners& corners, int material) {
    Surface& surface =
        builder_.AddFace(spec_.name + "/" + what + std::to_string(step), label, InWorld(corners), material);
    surface.detail = detail;
    return surface;
  }

  void BelongsToStep(int step, Surface* surface) const {
    surface->staircase_id = id_;
    surface->step_index = step;
  }

  /// Seen from below the stairs.
  Corners Upright(double x, double bottom, double top) const {
    return {{x, half_, bottom}, {x, -half_, bottom}, {x, -half_, top}, {x, half_, top}};
  }
  Corners Level(double from, double to, double z) const {
    return {{from, -half_, z}, {to, -half_, z}, {to, half_, z}, {from, half_, z}};
  }

  void MakeStep(int i) {
    const double run = (i - 1) * spec_.tread_m;
    const double low = (i - 1) * spec_.riser_m;
    const double high = i * spec_.riser_m;
    if (solid()) {
      Surface& riser = Place("riser", i, "stair_riser", false,
                             Upright(run, low, slabs() ? high - spec_.slab_m : high), riser_material_);
      BelongsToStep(i, &riser);
    }
    if (slabs()) MakeSlabFront(i, run, high);
    if (i < spec_.num_risers)
      MakeTread(i, run, high);
    else if (spec_.nosing_m > 0.0 && spec_.landing_m <= 0.0)  // the lip belongs to what follows
      Place("lip", i, "walkway", true, Level(run - spec_.nosing_m, run, high), material_);
  }

  void MakeSlabFront(int i, double run, double high) {
    const double front = run - spec_.nosing_m;
    const double low = high - spec_.slab_m;
    // The front of the slab is the upright part of an open step's edge, too thin to be asked for.
    Surface& edge = Place("edge", i, "stair_riser", true, Upright(front, low, high), material_);
    BelongsToStep(i, &edge);
    const bool last = i == spec_.num_risers;
    const double back = spec_.open_risers ? (last ? run : run + spec_.tread_m) : run;
    if (back - front > 1e-6) {
      Place("underside", i, "other", true,
            {{front, half_, low}, {back, half_, low}, {back, -half_, low}, {front, -half_, low}}, material_);
    }
  }

  void MakeTread(int i, double run, double high) {
    const double front = run - spec_.nosing_m;
    // Behind a riser the tread goes on under nothing: it ends at the next riser. Open treads overlap by
    // nothing.
    const double back = run + spec_.tread_m;
    Surface& tread = Place("tread", i, "stair_tread", false, Level(front, back, high), material_);
    BelongsToStep(i, &tread);
    if (!spec_.open_risers) return;
    const double low = high - spec_.slab_m;
    Place("back", i, "other", true,
          {{back, -half_, low}, {back, half_, low}, {back, half_, high}, {back, -half_, high}}, material_);
    for (const double side : {half_, -half_}) {
      Corners strip{{front, side, low}, {back, side, low}, {back, side, high}, {front, side, high}};
      if (side > 0.0) std::reverse(strip.begin(), strip.end());
      Place(side > 0.0 ? "left" : "right", i, "other", true, strip, material_);
    }
  }

  void MakeLanding() {
    builder_.AddFace(spec_.name + "/landing", "walkway", InWorld(Level(head_ - spec_.nosing_m, tail_, rise_)),
                     material_);
    builder_.AddFace(
        spec_.name + "/back", UprightLabel(rise_),
        InWorld({{tail_, -half_, 0}, {tail_, half_, 0}, {tail_, half_, rise_}, {tail_, -half_, rise_}}),
        riser_material_);
    if (spec_.open_risers) {
      builder_.AddFace(spec_.name + "/landing front", UprightLabel(rise_),
                       InWorld(Upright(head_, 0.0, rise_ - spec_.slab_m)), riser_material_);
    }
  }

  void MakeSide(double side) {
    // The profile of the flight, from its foot up, along the landing and back along the ground.
    Corners profile;
    std::vector<Corners> columns;
    const auto column = [&](double from, double to, double height) {
      profile.insert(profile.end(), {{from, side, height}, {to, side, height}});
      columns.push_back({{from, side, 0}, {to, side, 0}, {to, side, height}, {from, side, height}});
    };
    profile.push_back({solid() ? 0.0 : head_, side, 0});
    if (solid()) {
      for (int i = 1; i < spec_.num_risers; ++i)
        column((i - 1) * spec_.tread_m, i * spec_.tread_m, i * spec_.riser_m);
    }
    if (spec_.landing_m > 0.0) column(head_, tail_, rise_);
    profile.push_back({profile.back().x(), side, 0});
    std::reverse(profile.begin(), profile.end());  // now counter-clockwise from the right of the stairs
    if (side > 0.0) {
      std::reverse(profile.begin(), profile.end());
      for (Corners& corners : columns) std::reverse(corners.begin(), corners.end());
    }
    Surface& face = builder_.AddFace(spec_.name + (side > 0.0 ? "/side left" : "/side right"),
                                     UprightLabel(rise_), InWorld(profile), riser_material_);
    face.pieces.clear();
    for (const Corners& corners : columns) face.pieces.push_back(InWorld(corners));
  }

  void LeaveOutOfFloor() {
    if (solid())
      builder_.AddFootprint(InWorld(Level(0.0, spec_.landing_m > 0.0 ? tail_ : head_, 0.0)));
    else if (spec_.landing_m > 0.0)
      builder_.AddFootprint(InWorld(Level(head_, tail_, 0.0)));
  }

  SceneStaircase Truth() const {
    SceneStaircase stairs;
    stairs.truth.id = id_;
    stairs.truth.num_risers = spec_.num_risers;
    stairs.truth.num_treads = spec_.num_risers - 1;
    stairs.truth.riser_m = spec_.riser_m;
    stairs.truth.tread_m = spec_.tread_m;
    stairs.truth.width_m = spec_.width_m;
    stairs.truth.riser_heights_m.assign(static_cast<std::size_t>(spec_.num_risers), spec_.riser_m);
    stairs.truth.tread_depths_m.assign(static_cast<std::size_t>(spec_.num_risers - 1), spec_.tread_m);
    stairs.truth.direction_up_world = T_world_stairs_.linear().col(0);
    stairs.open_risers = spec_.open_risers;
    const auto edge = [&](double x, double z) {
      return std::array{Eigen::Vector3d(T_world_stairs_ * Eigen::Vector3d(x, half_, z)),
                        Eigen::Vector3d(T_world_stairs_ * Eigen::Vector3d(x, -half_, z))};
    };
    stairs.truth.foot_edge_world = edge(0.0, 0.0);
    stairs.truth.head_edge_world = edge(head_, rise_);
    return stairs;
  }

  const StaircaseSpec& spec_;
  const int material_, riser_material_;
  const int id_;  ///< of the staircase
  SceneBuilder& builder_;
  const Eigen::Isometry3d T_world_stairs_;
  const double half_;  ///< of the width [m]
  const double head_;  ///< x of the last riser
  const double rise_;  ///< z of the landing
  const double tail_;  ///< x of its end
};

}  // namespace

void SceneBuilder::AddStaircase(const StaircaseSpec& spec, int material, int riser_material) {
  const int id = static_cast<int>(scene_.staircases.size()) + 1;
  scene_.staircases.push_back(FlightMaker(spec, material, riser_material, id, this).Make());
}

}  // namespace terrace::synthetic
