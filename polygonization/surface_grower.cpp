// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_grower.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/angles.h"

namespace terrace {
namespace {

constexpr int kRounds = 2;
/// A patch too small to have a direction of its own still has to look roughly the same way.
constexpr double kMaxExtraAngle_rad = 0.5;
/// A member leaves its surface only when it fits this much worse than a newcomer may.
constexpr double kLeaveFactor = 1.5;
/// A cell whose points were forgotten gets new patches when they show this share of the area known before.
constexpr double kMuchOfTheArea = 0.8;
/// By how much the points of a patch may stand off a plane because of their tilt alone, root mean square:
/// what matching errs by over the width of a patch, and a share of the noise. Strict for patches that lean
/// the same way as those around them, which chance does not make them do; and for surfaces to be joined.
constexpr double kLeaning_m = 0.002, kLeaningNoise = 0.5;
constexpr double kJoining_m = 0.006, kJoiningNoise = 1.0;

double AngleBetween(const Plane& a, const Plane& b) {
  return std::acos(std::clamp(a.normal.dot(b.normal), -1.0, 1.0));
}

/// How a patch leans against a plane: the part of its normal that lies in the plane, about the angle in
/// radians.
Eigen::Vector3d Lean(const Member& member, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d& own = member.patch.plane_world.normal;
  return own - own.dot(normal) * normal;
}

/// Mean square by which points stand off a plane that they do not lie in the way of.
double LeanSquared(const Eigen::Vector3d& lean, const Eigen::Matrix3d& spread) {
  return lean.dot(spread * lean);
}

}  // namespace

void SurfaceGrower::Grow(const PatchUpdate& update) {
  Replace(update);
  EvictLeaning(update);
  for (int round = 0; round < kRounds && (round == 0 || !homeless_.empty()); ++round) {
    FindHomes();
    JoinSurfaces(update);
    store_.RefitTouched();
    EvictMisfits();
  }
  for (const MemberRef& ref : homeless_) store_.Found(ref);
  homeless_.clear();
  left_.clear();
  store_.RefitTouched();
}

bool SurfaceGrower::KnowsAsMuch(const PatchUpdate::CellPatches& cell) const {
  const CellMembers* known = store_.Find(cell.key);
  if (known == nullptr || !known->folded) return true;
  double before_m2 = 0.0, now_m2 = 0.0;
  for (const Member& member : known->members) before_m2 += member.patch.area_m2;
  for (const Patch& patch : cell.patches) now_m2 += patch.area_m2;
  return now_m2 >= kMuchOfTheArea * before_m2;
}

/// A new patch that fits the surface of an old one of its cell goes straight there.
void SurfaceGrower::Replace(const PatchUpdate& update) {
  homeless_.clear();
  for (const PatchUpdate::CellPatches& cell : update.cells) {
    if (!KnowsAsMuch(cell)) continue;
    const std::vector<Member> old = store_.TakeOut(cell.key);
    for (const Patch& patch : cell.patches) {
      const MemberRef ref = store_.Add(cell.key, cell.centre_world, patch);
      Member& member = store_.At(ref);
      double best = std::numeric_limits<double>::infinity();
      SurfaceId home = kNoSurface;
      for (const Member& before : old) {
        if (before.surface == kNoSurface) continue;
        const std::optional<double> misfit = Misfit(member, store_.surfaces().at(before.surface), 1.0);
        if (!misfit || *misfit >= best) continue;
        best = *misfit;
        home = before.surface;
        member.polygon = before.polygon;
      }
      if (home != kNoSurface)
        store_.Join(ref, home);
      else
        homeless_.push_back(ref);
    }
  }
}

/// The steps of a flight, as they are seen from afar, are one slanting plane. From nearby each patch of it is
/// level, and a single one could err; that those around it lean the same way is no chance.
void SurfaceGrower::EvictLeaning(const PatchUpdate& update) {
  for (const PatchUpdate::CellPatches& cell : update.cells) {
    const CellMembers* known = store_.Find(cell.key);
    for (int i = 0; known && i < static_cast<int>(known->members.size()); ++i) {
      const Member& member = known->members[static_cast<std::size_t>(i)];
      if (member.surface != kNoSurface && LeansWithOthers(cell.key, member))
        left_[{cell.key, i}] = member.surface;
    }
  }
  for (const auto& [ref, id] : left_) {
    store_.Leave(ref);
    homeless_.push_back(ref);
  }
}

bool SurfaceGrower::LeansWithOthers(const CellKey& key, const Member& member) const {
  const Eigen::Vector3d normal = store_.surfaces().at(member.surface).plane_world.normal;
  const Eigen::Matrix3d spread = member.patch.moments.Covariance();
  const double limit_m = kLeaning_m + kLeaningNoise * member.patch.most_noise_m;
  const Eigen::Vector3d lean = Lean(member, normal);
  if (LeanSquared(lean, spread) < limit_m * limit_m) return false;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area_m2 = 0.0;
  store_.ForEachAround(key, [&](const CellKey&, const CellMembers& around) {
    for (const Member& other : around.members) {
      if (other.surface != member.surface) continue;
      sum += other.patch.area_m2 * Lean(other, normal);
      area_m2 += other.patch.area_m2;
    }
  });
  const Eigen::Vector3d mean = sum / area_m2;
  return mean.dot(lean) > 0.0 && LeanSquared(mean, spread) >= limit_m * limit_m;
}

bool SurfaceGrower::TooLarge(const Eigen::AlignedBox3d& box_world) const {
  return box_world.sizes().maxCoeff() > config_.max_extent_m;
}

std::optional<double> SurfaceGrower::Misfit(const Member& member, const Surface& surface,
                                            double slack) const {
  const Plane& plane = surface.plane_world;
  const double angle = AngleBetween(plane, member.patch.plane_world);
  const double max_angle =
      Radians(slack * config_.max_angle_deg) +
      std::min(kMaxExtraAngle_rad, 2.0 * (member.angle_sigma_rad + surface.angle_sigma_rad));
  if (angle > max_angle) return std::nullopt;
  const double offset = std::abs(plane.SignedDistance(member.mean_world));
  const double max_offset = slack * (config_.max_offset_m + 2.0 * member.patch.most_noise_m);
  if (offset > max_offset) return std::nullopt;
  // The farthest end of the patch must not stand off either, where its own direction is known.
  const double reach = 0.5 * (member.high_world - member.low_world).norm();
  const double tilt = std::max(0.0, angle - 2.0 * member.angle_sigma_rad);
  if (offset + reach * std::sin(tilt) > 2.0 * max_offset) return std::nullopt;
  return offset / max_offset + angle / max_angle;
}

bool SurfaceGrower::Near(const Member& a, const Member& b) const {
  return ((a.low_world - b.high_world).array() <= config_.max_gap_m).all() &&
         ((b.low_world - a.high_world).array() <= config_.max_gap_m).all();
}

/// Calls visit(member) for every patch of the cell and the 26 around it that comes near the given one.
template <typename Visitor>
void SurfaceGrower::ForEachNeighbour(const MemberRef& ref, const Visitor& visit) const {
  const Member& member = store_.At(ref);
  store_.ForEachAround(ref.cell, [&](const CellKey& key, const CellMembers& cell) {
    for (int i = 0; i < static_cast<int>(cell.members.size()); ++i) {
      const Member& neighbour = cell.members[static_cast<std::size_t>(i)];
      if (MemberRef{key, i} != ref && Near(member, neighbour)) visit(neighbour);
    }
  });
}

/// Region growing: each homeless patch joins the neighbouring surface that it fits best, best-known patches
/// first; one that fits none founds a surface that others may join.
void SurfaceGrower::FindHomes() {
  std::vector<MemberRef> queue;
  queue.swap(homeless_);
  std::sort(queue.begin(), queue.end(), [&](const MemberRef& a, const MemberRef& b) {
    const double wa = store_.At(a).patch.area_m2, wb = store_.At(b).patch.area_m2;
    return wa != wb ? wa > wb : a < b;
  });
  for (const MemberRef& ref : queue) {
    const Eigen::AlignedBox3d box(store_.At(ref).low_world, store_.At(ref).high_world);
    SurfaceId home = kNoSurface;
    double best = std::numeric_limits<double>::infinity();
    const auto left = left_.find(ref);
    ForEachNeighbour(ref, [&](const Member& neighbour) {
      if (neighbour.surface == kNoSurface || neighbour.surface == home) return;
      if (left != left_.end() && left->second == neighbour.surface) return;
      const Surface& candidate = store_.surfaces().at(neighbour.surface);
      if (TooLarge(candidate.box_world.merged(box))) return;
      const std::optional<double> misfit = Misfit(store_.At(ref), candidate, 1.0);
      if (!misfit || *misfit > best || (*misfit == best && neighbour.surface > home)) return;
      best = *misfit;
      home = neighbour.surface;
    });
    if (home == kNoSurface)
      store_.Found(ref);
    else
      store_.Join(ref, home);
  }
}

/// Joins neighbouring surfaces whose points one plane explains.
void SurfaceGrower::JoinSurfaces(const PatchUpdate& update) {
  store_.RefitTouched();
  const std::map<SurfaceId, Surface>& surfaces = store_.surfaces();
  // Pairs that meet in or beside a cell that changed.
  std::set<std::pair<SurfaceId, SurfaceId>> pairs;
  for (const PatchUpdate::CellPatches& cell : update.cells) {
    const CellMembers* known = store_.Find(cell.key);
    for (int i = 0; known && i < static_cast<int>(known->members.size()); ++i) {
      const Member& member = known->members[static_cast<std::size_t>(i)];
      if (member.surface == kNoSurface) continue;
      const Surface& surface = surfaces.at(member.surface);
      ForEachNeighbour({cell.key, i}, [&](const Member& neighbour) {
        if (neighbour.surface == kNoSurface || neighbour.surface == member.surface) return;
        if (!Misfit(member, surfaces.at(neighbour.surface), 1.0) && !Misfit(neighbour, surface, 1.0)) return;
        pairs.insert(std::minmax(member.surface, neighbour.surface));
      });
    }
  }
  for (const auto& [a, b] : pairs) {
    const SurfaceId first = Survivor(a), second = Survivor(b);
    if (first == second || !OnePlane(surfaces.at(first), surfaces.at(second))) continue;
    if (TooLarge(surfaces.at(first).box_world.merged(surfaces.at(second).box_world))) continue;
    const bool keep_first = surfaces.at(first).moments.weight >= surfaces.at(second).moments.weight;
    const SurfaceId keep = keep_first ? first : second, lose = keep_first ? second : first;
    store_.Absorb(keep, lose);
    absorbed_by_[lose] = keep;
  }
  absorbed_by_.clear();
}

SurfaceId SurfaceGrower::Survivor(SurfaceId id) const {
  for (auto found = absorbed_by_.find(id); found != absorbed_by_.end(); found = absorbed_by_.find(id))
    id = found->second;
  return id;
}

bool SurfaceGrower::OnePlane(const Surface& a, const Surface& b) const {
  if (AngleBetween(a.plane_world, b.plane_world) >
      Radians(config_.max_angle_deg) +
          std::min(kMaxExtraAngle_rad, 2.0 * (a.angle_sigma_rad + b.angle_sigma_rad)))
    return false;
  const bool a_larger = a.moments.weight >= b.moments.weight;
  const Surface &large = a_larger ? a : b, &small = a_larger ? b : a;
  PlaneMoments both = large.moments;
  const Eigen::Vector3d shift = small.origin_world - large.origin_world;
  both.Add(small.moments, shift);
  const Plane plane = both.Fit(large.plane_world.normal);
  PlaneMoments shifted;
  shifted.Add(small.moments, shift);
  const auto explains = [&](const PlaneMoments& moments, double noise_m) {
    const Plane own = moments.Fit(plane.normal);
    const double joining_m = kJoining_m + kJoiningNoise * noise_m;
    const Eigen::Matrix3d spread = moments.Covariance();
    if (plane.normal.dot(spread * plane.normal) - own.normal.dot(spread * own.normal) > joining_m * joining_m)
      return false;
    const double limit = 0.7 * config_.max_offset_m + 1.5 * noise_m;
    return moments.MeanSquaredDistance(plane) < limit * limit;
  };
  return explains(large.moments, large.noise_m) && explains(shifted, small.noise_m);
}

void SurfaceGrower::EvictMisfits() {
  const std::set<SurfaceId> touched = store_.touched();
  for (const SurfaceId id : touched) {
    const auto found = store_.surfaces().find(id);
    if (found == store_.surfaces().end()) continue;
    const std::vector<MemberRef> evicted = store_.Evict(
        id, [&](const Member& member) { return Misfit(member, found->second, kLeaveFactor).has_value(); });
    homeless_.insert(homeless_.end(), evicted.begin(), evicted.end());
  }
}

}  // namespace terrace
