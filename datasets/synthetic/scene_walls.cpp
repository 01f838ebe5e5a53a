// SPDX-License-Identifier: BSD-3-Clause
// Walls with doors and windows.
#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "datasets/synthetic/scene_builder.h"

namespace terrace::synthetic {
namespace {

using Opening = WallSpec::Opening;

/// An upright rectangle between two points of the ground, seen from the right of the way from a to b.
Ring Upright(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double height_m) {
  const Eigen::Vector3d up(0, 0, height_m);
  return {a, b, b + up, a + up};
}

/// Makes the planes of one wall.
class WallMaker {
 public:
  WallMaker(const WallSpec& spec, int material, SceneBuilder* builder)
      : spec_(spec), material_(material), builder_(*builder), length_m_((spec.to - spec.from).norm()) {
    const Eigen::Vector2d along = (spec.to - spec.from).normalized();
    along_ = {along.x(), along.y(), 0.0};
  }

  void Make() {
    const Eigen::Vector3d foot(spec_.from.x(), spec_.from.y(), spec_.z_m);
    MakeFace(foot, false);
    if (spec_.thickness_m <= 0.0) return;
    const Eigen::Vector3d left(-along_.y(), along_.x(), 0.0);
    const Eigen::Vector3d back = foot - spec_.thickness_m * left;
    MakeFace(back, true);
    MakeEnds(foot, back);
    for (const Opening& opening : spec_.openings) MakeReveals(foot, back, opening);
  }

 private:
  Ring Rectangle(const Eigen::Vector3d& foot, bool behind, double from, double to, double bottom,
                 double top) const {
    // Seen from the left, the way from `from` to `to` runs to the left.
    const double first = behind ? from : to;
    const double last = behind ? to : from;
    return {foot + first * along_ + bottom * Eigen::Vector3d::UnitZ(),
            foot + last * along_ + bottom * Eigen::Vector3d::UnitZ(),
            foot + last * along_ + top * Eigen::Vector3d::UnitZ(),
            foot + first * along_ + top * Eigen::Vector3d::UnitZ()};
  }

  void MakeFace(const Eigen::Vector3d& foot, bool behind) {
    Surface& wall = builder_.AddFace(behind ? spec_.name + " back" : spec_.name, spec_.label,
                                     Rectangle(foot, behind, 0.0, length_m_, 0.0, spec_.height_m), material_);
    if (spec_.openings.empty()) return;
    for (const Opening& o : spec_.openings) {
      const bool at_edge =
          o.bottom_m <= 0.0 || o.top_m >= spec_.height_m || o.from_m <= 0.0 || o.to_m >= length_m_;
      if (!at_edge)
        wall.holes_world.push_back(Rectangle(foot, behind, o.from_m, o.to_m, o.bottom_m, o.top_m));
    }
    wall.pieces = PiecesBetween(foot, behind);
    CutDoors(foot, behind, &wall);
  }

  /// Cut along all edges of all openings; what lies in none is wall.
  std::vector<Ring> PiecesBetween(const Eigen::Vector3d& foot, bool behind) const {
    std::vector<double> cuts_along{0.0, length_m_};
    std::vector<double> cuts_up{0.0, spec_.height_m};
    for (const Opening& o : spec_.openings) {
      cuts_along.insert(cuts_along.end(), {o.from_m, o.to_m});
      cuts_up.insert(cuts_up.end(), {o.bottom_m, o.top_m});
    }
    std::sort(cuts_along.begin(), cuts_along.end());
    std::sort(cuts_up.begin(), cuts_up.end());
    std::vector<Ring> pieces;
    for (std::size_t i = 0; i + 1 < cuts_along.size(); ++i) {
      for (std::size_t j = 0; j + 1 < cuts_up.size(); ++j) {
        if (cuts_along[i + 1] - cuts_along[i] < 1e-9 || cuts_up[j + 1] - cuts_up[j] < 1e-9) continue;
        const double u = 0.5 * (cuts_along[i] + cuts_along[i + 1]);
        const double v = 0.5 * (cuts_up[j] + cuts_up[j + 1]);
        const bool open = std::any_of(spec_.openings.begin(), spec_.openings.end(), [&](const Opening& o) {
          return o.from_m < u && u < o.to_m && o.bottom_m < v && v < o.top_m;
        });
        if (!open)
          pieces.push_back(
              Rectangle(foot, behind, cuts_along[i], cuts_along[i + 1], cuts_up[j], cuts_up[j + 1]));
      }
    }
    return pieces;
  }

  /// Doors reach the floor: they are part of the outline, cut from its foot from left to right.
  void CutDoors(const Eigen::Vector3d& foot, bool behind, Surface* wall) const {
    std::vector<Opening> doors;
    std::copy_if(spec_.openings.begin(), spec_.openings.end(), std::back_inserter(doors),
                 [](const Opening& o) { return o.bottom_m <= 0.0; });
    std::sort(doors.begin(), doors.end(),
              [](const Opening& a, const Opening& b) { return a.from_m < b.from_m; });
    if (doors.empty()) return;
    Ring outline{foot};
    for (const Opening& door : doors) {
      const Eigen::Vector3d up = door.top_m * Eigen::Vector3d::UnitZ();
      outline.insert(outline.end(), {foot + door.from_m * along_, foot + door.from_m * along_ + up,
                                     foot + door.to_m * along_ + up, foot + door.to_m * along_});
    }
    outline.insert(outline.end(), {foot + length_m_ * along_,
                                   foot + length_m_ * along_ + spec_.height_m * Eigen::Vector3d::UnitZ(),
                                   foot + spec_.height_m * Eigen::Vector3d::UnitZ()});
    if (!behind) std::reverse(outline.begin(), outline.end());
    wall->outline_world = outline;
  }

  void MakeTrim(const std::string& what, const Ring& ring) {
    Surface& surface = builder_.AddFace(spec_.name + " " + what, spec_.label, ring, material_);
    surface.detail = true;
  }

  void MakeEnds(const Eigen::Vector3d& foot, const Eigen::Vector3d& back) {
    const Eigen::Vector3d end = foot + length_m_ * along_;
    const Eigen::Vector3d back_end = back + length_m_ * along_;
    const Eigen::Vector3d up(0, 0, spec_.height_m);
    MakeTrim("start", Upright(foot, back, spec_.height_m));
    MakeTrim("end", Upright(back_end, end, spec_.height_m));
    MakeTrim("top", {foot + up, back + up, back_end + up, end + up});
  }

  /// The faces within the thickness of the wall around an opening.
  void MakeReveals(const Eigen::Vector3d& foot, const Eigen::Vector3d& back, const Opening& o) {
    const Eigen::Vector3d low(0, 0, o.bottom_m);
    const Eigen::Vector3d high(0, 0, o.top_m);
    const double height = o.top_m - o.bottom_m;
    MakeTrim("reveal", Upright(back + o.from_m * along_ + low, foot + o.from_m * along_ + low, height));
    MakeTrim("reveal", Upright(foot + o.to_m * along_ + low, back + o.to_m * along_ + low, height));
    MakeTrim("lintel", {back + o.from_m * along_ + high, foot + o.from_m * along_ + high,
                        foot + o.to_m * along_ + high, back + o.to_m * along_ + high});
    if (o.bottom_m > 0.0) {
      MakeTrim("sill", {foot + o.from_m * along_ + low, back + o.from_m * along_ + low,
                        back + o.to_m * along_ + low, foot + o.to_m * along_ + low});
    }
  }

  const WallSpec& spec_;
  const int material_;
  SceneBuilder& builder_;
  const double length_m_;
  Eigen::Vector3d along_;  ///< unit, level
};

}  // namespace

void SceneBuilder::AddWall(const WallSpec& spec, int material) { WallMaker(spec, material, this).Make(); }

}  // namespace terrace::synthetic
