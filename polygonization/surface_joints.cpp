// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_joints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "polygonization/joint_line.h"

namespace terrace {
namespace {

/// So far from this plane another surface must have been seen to meet it: nearer, pixels agree with both.
constexpr std::array<double, 2> kApart_m{0.02, 0.035};
/// Where nothing is known of it so near, it is asked here: a wall of little texture is often known from some
/// way up only.
constexpr std::array<double, 3> kFarApart_m{0.07, 0.12, 0.18};
constexpr std::array<double, 3> kHigherThanSteps_m{0.35, 0.42, 0.5};
/// Beyond the end of one of two surfaces that meet, pixels of the other agree with it in a strip along the
/// line. It is there where it is seen farther from the line than this: a face on ground, and ground at a
/// face.
struct Strip {
  double half_width_m;
  std::array<double, 3> beside_m;
  bool other_is_high;  // the other surface is higher than a step there; else it is seen on both sides of this
                       // one
};
constexpr Strip kFaceStrip{0.045, {0.05, 0.065, 0.08}, false};
constexpr Strip kGroundStrip{0.1, {0.1, 0.13, 0.16}, true};
/// Where the face of a step is no longer seen, its line is followed for so long, if the ground beyond it is
/// of another level: a kerb far away.
constexpr double kOnward_m = 1.5;
/// Ground of another level is at least so much higher or lower.
constexpr double kLeastStep_m = 0.03;
/// Where it is asked, beyond the blur of the line, on which side this surface goes on; farther out the
/// flatter the angle, since pixels beyond the line agree with both planes the longer.
constexpr std::array<double, 5> kProbes_m{0.03, 0.045, 0.06, 0.08, 0.10};
/// Where a surface seems to go on behind a face that rises from it, it does only when it is seen this far
/// behind, too: nearer, the foot of a face far away agrees with both.
constexpr std::array<double, 3> kFarProbes_m{0.3, 0.4, 0.5};
constexpr int kGoesOnFar = 2;
constexpr int kGoesOn = 4;   // probes
constexpr int kClearly = 2;  // more of them
/// How far beyond the line what agreed with this plane belongs to the other, at a right angle.
constexpr double kCut_m = 0.12;
constexpr double kMostCut_m = 0.4;
/// A gap before the line is closed up to here.
constexpr double kFill_m = 0.035;
constexpr double kLeastStretch_m = 0.04;
/// The other surface is taken to go on where it was not seen for no longer than this.
constexpr double kBridge_m = 0.15;
/// A decision that holds for no longer than this, between two that are alike, is none.
constexpr double kFlicker_m = 0.04;
/// A level surface, and an upright one: cosine and sine between the normal and up.
constexpr double kLevel = 0.9;
constexpr double kUpright = 0.3;
/// Beyond the end of the edge of a step the face below it is asked here whether it goes on above, too, and as
/// far before it whether it does not.
constexpr std::array<double, 4> kBeyond_m{0.03, 0.05, 0.07, 0.09};
constexpr double kAbove_m = 0.06;
constexpr int kIsWall = 3;
/// The face of a step is not higher than this.
constexpr double kMostFace_m = 0.6;
/// A pixel holds a point of every square grid as fine as this, however the grid is turned: half its diagonal
/// is less than half a pixel.
constexpr double kStride_px = 0.7;

/// Ground beside another one.
struct Level {
  PlaneFrame frame;
  EvidenceGrid::Reader evidence;
};

/// On which side of a line a surface goes on; `kUnsaid` where nothing is known of it.
enum class Keep { kUnsaid, kFront, kBehind, kBoth };

/// One surface cut by one other.
class Joint {
 public:
  Joint(const Surface& surface, const Surface& other, const JointLine& line,
        const std::vector<const Surface*>& levels, PlaneBitmap* bitmap)
      : frame_(surface.Frame()),
        other_frame_(other.Frame()),
        other_evidence_(other.evidence),
        line_(line),
        bitmap_(*bitmap) {
    const Eigen::Vector3d& n = other.plane_world.normal;
    const Eigen::Vector3d& own = surface.plane_world.normal;
    const Eigen::Vector3d up = (own - own.dot(n) * n).normalized();
    up_other_ = {other.axes.x.dot(up), other.axes.y.dot(up)};
    scale_ = std::clamp(0.5 / line.sine, 1.0, 4.0);
    if (n.z() > kLevel && std::abs(own.z()) < kUpright) strip_ = &kFaceStrip;
    if (own.z() > kLevel && std::abs(n.z()) < kUpright) strip_ = &kGroundStrip;
    step_over_face_ = n.z() > kLevel && std::abs(own.z()) < kUpright;
    for (const Surface* level : levels)
      levels_.push_back({level->Frame(), EvidenceGrid::Reader(level->evidence)});
  }

  /// Cuts along the stretch [from, to] of the line, and appends where it did.
  void Cut(double from_m, double to_m, std::vector<EdgeLine>* lines) {
    const double step = kStride_px * bitmap_.pixel_m;
    const auto at = [&](int i) -> Eigen::Vector2d { return line_.point + (from_m + i * step) * line_.along; };
    std::vector<Stretch> stretches;
    for (int i = 0; from_m + i * step <= to_m; ++i) {
      const Keep keep = Decide(at(i));
      if (stretches.empty() || stretches.back().keep != keep) stretches.push_back({keep, i, i});
      stretches.back().end = i + 1;
    }
    Settle(step, &stretches);
    for (const Stretch& stretch : stretches) {
      if (stretch.keep == Keep::kUnsaid) continue;
      for (int i = stretch.begin; i < stretch.end; ++i) Paint(at(i), stretch.keep);
      const double began = from_m + stretch.begin * step, ended = from_m + (stretch.end - 1) * step;
      if (stretch.keep == Keep::kBoth || ended - began < kLeastStretch_m) continue;
      const double sign = stretch.keep == Keep::kFront ? 1.0 : -1.0;
      lines->push_back({line_.point, line_.along, sign * line_.to_front, began, ended});
      if (!levels_.empty()) {
        EndAtOtherLevel(line_.point + began * line_.along, -line_.along);
        EndAtOtherLevel(line_.point + ended * line_.along, line_.along);
      }
      if (step_over_face_ && stretch.keep == Keep::kBehind) {
        PartFromWall(line_.point + began * line_.along, -line_.along, lines);
        PartFromWall(line_.point + ended * line_.along, line_.along, lines);
      }
    }
  }

 private:
  /// Points of the line, one after the other, at which the same is decided.
  struct Stretch {
    Keep keep;
    int begin, end;
  };

  /// Short stretches between two alike are taken to be like them: where the decision flickers, and, somewhat
  /// longer, where the other surface was not seen.
  static void Settle(double step_m, std::vector<Stretch>* stretches) {
    std::vector<Stretch> settled;
    for (const Stretch& stretch : *stretches) {
      settled.push_back(stretch);
      while (settled.size() >= 3) {
        const Stretch& before = settled[settled.size() - 3];
        const Stretch& between = settled[settled.size() - 2];
        const double longest = between.keep == Keep::kUnsaid ? kBridge_m : kFlicker_m;
        if (before.keep != settled.back().keep || before.keep == Keep::kUnsaid ||
            (between.end - between.begin) * step_m > longest)
          break;
        const Stretch joined{before.keep, before.begin, settled.back().end};
        settled.resize(settled.size() - 3);
        settled.push_back(joined);
      }
    }
    *stretches = std::move(settled);
  }

  /// On which sides of the line this surface goes on at one point of it.
  Keep Decide(const Eigen::Vector2d& at) {
    int front = 0, behind = 0;
    for (const double d : kProbes_m) {
      front += bitmap_.OnAt(at + scale_ * d * line_.to_front);
      behind += bitmap_.OnAt(at - scale_ * d * line_.to_front);
    }
    if (front + behind == 0) return Keep::kUnsaid;
    const Eigen::Vector2d on_other = other_frame_.ToPlane(frame_.ToWorld(at));
    bool above = false, below = false;  // the other surface, seen from this one
    bool seen_through = false;
    for (const double apart : kApart_m) {
      above = above || OtherIsOn(on_other, apart);
      below = below || OtherIsOn(on_other, -apart);
      seen_through = seen_through ||
                     other_evidence_.At(on_other + apart / line_.sine * up_other_) <= EvidenceGrid::kThrough;
    }
    if (!above && !below && !seen_through) above = IsWall(on_other);
    if (!above && !below) return Keep::kUnsaid;
    if (strip_ != nullptr && (strip_->other_is_high ? IsHigh(on_other) : above && below) && IsStrip(at)) {
      for (double d = -strip_->half_width_m; d <= strip_->half_width_m; d += kStride_px * bitmap_.pixel_m)
        Bar(bitmap_.PixelAt(at + d * line_.to_front));
      return Keep::kUnsaid;
    }
    if (front >= behind + kClearly) return Keep::kFront;
    if (behind >= front + kClearly) return Keep::kBehind;
    // What rises from a surface hides what lies behind it; what falls away from it has it behind itself.
    if (front >= kGoesOn && behind >= kGoesOn) {
      const bool far_front = GoesOnFar(at, line_.to_front), far_behind = GoesOnFar(at, -line_.to_front);
      if (far_front == far_behind) return above ? Keep::kBoth : Keep::kUnsaid;
      return far_front ? Keep::kFront : Keep::kBehind;
    }
    return above ? Keep::kFront : Keep::kBehind;
  }

  /// A riser may lie in one plane with the wall beside the steps: where the edge of its tread ends, over
  /// which one sees through the plane, and the face goes on above, the two are parted.
  /// @param onward  along the line, away from the tread
  void PartFromWall(const Eigen::Vector2d& end, const Eigen::Vector2d& onward, std::vector<EdgeLine>* lines) {
    const auto is_wall = [&](double d) {
      const cv::Point over_tread = bitmap_.PixelAt(end - d * onward + kAbove_m * line_.to_front);
      return bitmap_.OnAt(end + d * onward + kAbove_m * line_.to_front) && bitmap_.Holds(over_tread) &&
             bitmap_.barred(over_tread) != 0;
    };
    if (std::count_if(kBeyond_m.begin(), kBeyond_m.end(), is_wall) < kIsWall) return;
    const double step = kStride_px * bitmap_.pixel_m;
    const Eigen::Vector2d down = -line_.to_front;
    double depth = 0.0;
    while (depth < kMostFace_m && (depth < kFill_m || bitmap_.OnAt(end + depth * down))) depth += step;
    for (double d = -step; d <= depth + step; d += step)
      for (const double side : {-0.5 * step, 0.5 * step})
        Bar(bitmap_.PixelAt(end + d * down + side * onward));
    for (const Eigen::Vector2d& inside : {onward, Eigen::Vector2d(-onward)})
      lines->push_back({end, down, inside, 0.0, depth});
  }

  /// Whether only pixels of the other surface agree with this one, which has ended.
  bool IsStrip(const Eigen::Vector2d& at) const {
    return std::none_of(strip_->beside_m.begin(), strip_->beside_m.end(), [&](double d) {
      return bitmap_.OnAt(at + d * line_.to_front) || bitmap_.OnAt(at - d * line_.to_front);
    });
  }

  bool OtherIsOn(const Eigen::Vector2d& on_other, double up_m) {
    return other_evidence_.At(on_other + up_m / line_.sine * up_other_) >= EvidenceGrid::kOn;
  }
  /// Whether the other surface is higher than a step.
  bool IsHigh(const Eigen::Vector2d& on_other) {
    return std::any_of(kHigherThanSteps_m.begin(), kHigherThanSteps_m.end(),
                       [&](double up_m) { return OtherIsOn(on_other, up_m); });
  }
  /// Whether it is, and is seen again not far from this one.
  bool IsWall(const Eigen::Vector2d& on_other) {
    return IsHigh(on_other) && std::any_of(kFarApart_m.begin(), kFarApart_m.end(),
                                           [&](double up_m) { return OtherIsOn(on_other, up_m); });
  }

  /// Beyond the end of a face that was seen pixels may agree with the ground of both its levels. As far as
  /// they do without a gap, this surface ends at the line.
  /// @param onward  along the line, away from the face
  void EndAtOtherLevel(const Eigen::Vector2d& end, const Eigen::Vector2d& onward) {
    const double step = kStride_px * bitmap_.pixel_m;
    double claimed = 0.0;
    for (double along = step; along <= kOnward_m && along <= claimed + kBridge_m; along += step)
      if (BarClaimedTwice(end + along * onward)) claimed = along;
  }

  /// @return whether the ground of another level beyond the line claims some of what this surface does
  bool BarClaimedTwice(const Eigen::Vector2d& at) {
    const bool front = GoesOnFar(at, line_.to_front);
    if (front == GoesOnFar(at, -line_.to_front)) return false;
    const Eigen::Vector2d beyond = front ? Eigen::Vector2d(-line_.to_front) : line_.to_front;
    bool any = false;
    for (Level& level : levels_) {
      const auto is_on = [&](double d) {
        return level.evidence.At(level.frame.ToPlane(frame_.ToWorld(at + d * beyond))) >= EvidenceGrid::kOn;
      };
      const auto is_on_within = [&](double d) { return is_on(-d); };
      if (std::count_if(kFarProbes_m.begin(), kFarProbes_m.end(), is_on) < kGoesOnFar ||
          std::count_if(kFarProbes_m.begin(), kFarProbes_m.end(), is_on_within) >= kGoesOnFar)
        continue;
      const double step = kStride_px * bitmap_.pixel_m;
      for (double d = 0.0; d <= kMostCut_m; d += step) {
        if (!is_on(d)) continue;
        any = any || bitmap_.OnAt(at + d * beyond);
        Bar(at + d * beyond, Eigen::Vector2d(-beyond));
      }
    }
    return any;
  }

  bool GoesOnFar(const Eigen::Vector2d& at, const Eigen::Vector2d& way) const {
    return std::count_if(kFarProbes_m.begin(), kFarProbes_m.end(),
                         [&](double d) { return bitmap_.OnAt(at + d * way); }) >= kGoesOnFar;
  }

  void Paint(const Eigen::Vector2d& at, Keep keep) {
    const double step = kStride_px * bitmap_.pixel_m;
    if (keep == Keep::kBoth) {
      for (double d = -bitmap_.pixel_m; d <= bitmap_.pixel_m; d += step) Bar(at + d * line_.to_front, 0.75);
      return;
    }
    const Eigen::Vector2d inside = keep == Keep::kFront ? line_.to_front : Eigen::Vector2d(-line_.to_front);
    const double depth = std::min(kMostCut_m, scale_ * kCut_m);
    for (double d = 0.0; d <= kMostCut_m; d += step) {
      // Farther on only what hangs together with it.
      if (d > depth && !bitmap_.OnAt(at - d * inside)) break;
      Bar(at - d * inside, inside);
    }
    double filled = 0.0;
    while (filled <= kFill_m && !bitmap_.OnAt(at + (filled + step) * inside)) filled += step;
    if (filled > kFill_m) return;
    for (double d = step; d <= filled; d += step) {
      const cv::Point pixel = bitmap_.PixelAt(at + d * inside);
      if (bitmap_.Holds(pixel) && bitmap_.barred(pixel) == 0) bitmap_.on(pixel) = 255;
    }
  }

  /// A pixel on the far side of the line.
  void Bar(const Eigen::Vector2d& p, const Eigen::Vector2d& inside) {
    const cv::Point pixel = bitmap_.PixelAt(p);
    if (!bitmap_.Holds(pixel)) return;
    if (inside.dot(bitmap_.CentreOf(pixel.x, pixel.y) - line_.point) > 0.0) return;
    Bar(pixel);
  }
  /// A pixel on the line, within so many pixels.
  void Bar(const Eigen::Vector2d& p, double reach_px) {
    const cv::Point pixel = bitmap_.PixelAt(p);
    if (!bitmap_.Holds(pixel)) return;
    if (std::abs(line_.Across(bitmap_.CentreOf(pixel.x, pixel.y))) > reach_px * bitmap_.pixel_m) return;
    Bar(pixel);
  }
  void Bar(const cv::Point& pixel) {
    if (!bitmap_.Holds(pixel)) return;
    bitmap_.barred(pixel) = 255;
    bitmap_.on(pixel) = 0;
  }

  const PlaneFrame frame_, other_frame_;
  EvidenceGrid::Reader other_evidence_;
  std::vector<Level> levels_;  // above and below this surface
  const JointLine& line_;
  PlaneBitmap& bitmap_;
  Eigen::Vector2d up_other_;  // in the other plane, away from the line on the seen side of this one
  double scale_;
  const Strip* strip_ = nullptr;  // null: neither is ground
  bool step_over_face_;           // the other surface may be the tread over this one
};

/// Ground next to this surface that lies higher or lower by a step; none when this is no ground.
std::vector<const Surface*> LevelsBeside(const Surface& surface, const Neighbours& neighbours,
                                         const SurfaceStore& store) {
  std::vector<const Surface*> levels;
  if (surface.plane_world.normal.z() < kLevel) return levels;
  for (const auto& [other_id, box] : neighbours) {
    const Surface& other = store.surfaces().at(other_id);
    const double step_m = std::abs(surface.plane_world.SignedDistance(box.center()));
    if (other.plane_world.normal.z() > kLevel && step_m > kLeastStep_m && step_m < kMostFace_m)
      levels.push_back(&other);
  }
  return levels;
}

}  // namespace

std::vector<EdgeLine> CutAtJoints(SurfaceId id, const Neighbours& neighbours, const SurfaceStore& store,
                                  PlaneBitmap* bitmap) {
  std::vector<EdgeLine> lines;
  const Surface& surface = store.surfaces().at(id);
  const PlaneFrame frame = surface.Frame();
  const std::vector<const Surface*> levels = LevelsBeside(surface, neighbours, store);
  for (const auto& [other_id, box] : neighbours) {
    const Surface& other = store.surfaces().at(other_id);
    const std::optional<JointLine> line = LineOf(frame, other.plane_world);
    if (!line) continue;
    double from = std::numeric_limits<double>::infinity(), to = -from;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector2d p =
          frame.ToPlane(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))) - line->point;
      from = std::min(from, line->along.dot(p));
      to = std::max(to, line->along.dot(p));
    }
    const Eigen::AlignedBox2d bitmap_box(bitmap->low, bitmap->CentreOf(bitmap->on.cols, bitmap->on.rows));
    const std::optional<std::pair<double, double>> within = Within(*line, bitmap_box);
    if (within)
      Joint(surface, other, *line, levels, bitmap)
          .Cut(std::max(from, within->first), std::min(to, within->second), &lines);
  }
  return lines;
}

}  // namespace terrace
