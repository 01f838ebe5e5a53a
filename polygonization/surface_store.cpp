// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_store.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "core/rounding.h"

namespace terrace {
namespace {

/// The axes of a surface's outline are laid anew when its normal has turned by this much.
constexpr double kMaxTurn_rad = 0.15;

/// Standard deviation of the normal that moments alone support, across the narrow side of the patch.
double AngleSigma(const PlaneMoments& moments) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(moments.Covariance(), Eigen::EigenvaluesOnly);
  const double width2 = std::max(solver.eigenvalues()(1), 1e-8);
  return std::sqrt((1.0 / moments.weight + kSystematic_m * kSystematic_m) / width2);
}

/// The plane of a patch with axes in it, relative to the centre of the cell.
struct PatchAxes {
  Eigen::Vector3f origin, x, y;

  PatchAxes(const Plane& plane_world, const Eigen::Vector3d& centre_world) {
    const PlaneAxes axes = AxesOf(plane_world.normal);
    origin = (-plane_world.SignedDistance(centre_world) * plane_world.normal).cast<float>();
    x = axes.x.cast<float>();
    y = axes.y.cast<float>();
  }
  Eigen::Vector2f Along(const Eigen::Vector3f& v) const { return {x.dot(v), y.dot(v)}; }
};

std::vector<SmallFootprint> Small(const std::vector<Footprint>& footprints, const PatchAxes& axes) {
  std::vector<SmallFootprint> small;
  small.reserve(footprints.size());
  for (const Footprint& f : footprints) {
    const Eigen::Vector2f centre = axes.Along(f.centre - axes.origin), half_long = axes.Along(f.half_x);
    small.push_back({{Eigen::half(centre.x()), Eigen::half(centre.y())},
                     {Eigen::half(half_long.x()), Eigen::half(half_long.y())},
                     Eigen::half(f.half_y.norm())});
  }
  return small;
}

Member MakeMember(const Patch& patch, const Eigen::Vector3d& centre_world) {
  Member member;
  member.patch = patch;
  member.patch.footprints = std::vector<Footprint>();  // gives the room back, as {} would not
  member.footprints = Small(patch.footprints, {patch.plane_world, centre_world});
  member.mean_world = centre_world + patch.moments.Mean();
  member.low_world = centre_world + patch.low.cast<double>();
  member.high_world = centre_world + patch.high.cast<double>();
  member.angle_sigma_rad = AngleSigma(patch.moments);
  return member;
}

std::int64_t FootprintBytes(const Member& member) {
  return static_cast<std::int64_t>(member.footprints.capacity() * sizeof(SmallFootprint));
}

/// @return cells that belong to the surface only since
int AdoptEvidence(const PlaneFrame& theirs, const EvidenceGrid& evidence, Surface* to) {
  const PlaneFrame ours = to->Frame();
  const auto map = [&](const Eigen::Vector2d& p) { return theirs.ToPlane(ours.ToWorld(p)); };
  Eigen::Affine2d theirs_from_ours = Eigen::Affine2d::Identity();
  theirs_from_ours.translation() = map(Eigen::Vector2d::Zero());
  theirs_from_ours.linear() << map(Eigen::Vector2d::UnitX()) - theirs_from_ours.translation(),
      map(Eigen::Vector2d::UnitY()) - theirs_from_ours.translation();
  return to->evidence.Adopt(evidence, theirs_from_ours);
}

/// Takes evidence where the leaves of a member lie, and a little around them.
void OpenEvidence(const CellMembers& cell, const Member& member, Surface* surface) {
  constexpr double kAround_m = 0.01;
  const PlaneFrame frame = surface->Frame();
  // In groups; the one that holds the middle of the cell is split off, so that floats suffice for what is
  // left.
  const double groups_per_m = 1.0 / surface->evidence.group_m();
  Eigen::Matrix<double, 2, 3> to_axes;
  to_axes << surface->axes.x.transpose(), surface->axes.y.transpose();
  const Eigen::Matrix<float, 2, 3> to_groups = (groups_per_m * to_axes).cast<float>();
  const Eigen::Vector2d middle = groups_per_m * frame.ToPlane(cell.centre_world);
  const Eigen::Vector2i middle_group(FloorToInt(middle.x()), FloorToInt(middle.y()));
  const Eigen::Vector2f in_group = (middle - middle_group.cast<double>()).cast<float>();
  const Eigen::Vector2f around = Eigen::Vector2f::Constant(static_cast<float>(groups_per_m * kAround_m));
  EvidenceGrid::Opener opener(&surface->evidence);
  const PatchAxes axes(member.patch.plane_world, cell.centre_world);
  Eigen::Matrix2f along;  // groups for a metre along each axis of the patch
  along << to_groups * axes.x, to_groups * axes.y;
  const Eigen::Vector2f start = in_group + to_groups * axes.origin;
  for (const SmallFootprint& f : member.footprints) {
    const Eigen::Vector2f centre(static_cast<float>(f.centre[0]), static_cast<float>(f.centre[1]));
    const Eigen::Vector2f half_long(static_cast<float>(f.half_long[0]), static_cast<float>(f.half_long[1]));
    const float length = half_long.norm();
    const Eigen::Vector2f half_short = length > 0.0F
                                           ? Eigen::Vector2f(static_cast<float>(f.half_short) / length *
                                                             Eigen::Vector2f(-half_long.y(), half_long.x()))
                                           : Eigen::Vector2f::Zero();
    const Eigen::Vector2f at = start + along * centre;
    const Eigen::Vector2f reach = (along * half_long).cwiseAbs() + (along * half_short).cwiseAbs() + around;
    const Eigen::Vector2f low = at - reach, high = at + reach;
    opener.OpenGroups(middle_group + Eigen::Vector2i(FloorToInt(low.x()), FloorToInt(low.y())),
                      middle_group + Eigen::Vector2i(FloorToInt(high.x()), FloorToInt(high.y())));
  }
  if (!cell.folded) return;
  // Where the leaves lay is forgotten: the box around them is what is left.
  Eigen::AlignedBox2d box;
  const Eigen::AlignedBox3d box_world(member.low_world, member.high_world);
  for (int corner = 0; corner < 8; ++corner)
    box.extend(frame.ToPlane(box_world.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
  surface->evidence.Open(box.min(), box.max());
}

/// Lays the axes anew; evidence and pieces go along.
void Anchor(Surface* surface) {
  const PlaneFrame before = surface->Frame();
  const EvidenceGrid evidence = std::exchange(surface->evidence, EvidenceGrid(surface->evidence.cell_m()));
  surface->anchor_normal = surface->plane_world.normal;
  surface->axes = AxesOf(surface->anchor_normal);
  surface->trace_now = true;
  AdoptEvidence(before, evidence, surface);
  const PlaneFrame after = surface->Frame();
  const auto move = [&](Eigen::Vector2d* p) { *p = after.ToPlane(before.ToWorld(*p)); };
  for (TracedPiece& piece : surface->pieces) {
    move(&piece.centroid);
    for (Eigen::Vector2d& p : piece.outline) move(&p);
    for (Ring2& hole : piece.holes)
      for (Eigen::Vector2d& p : hole) move(&p);
  }
}

}  // namespace

std::size_t SurfaceStore::CellKeyHash::operator()(const CellKey& key) const {
  std::uint64_t h = static_cast<std::uint32_t>(key.x);
  h = h * 0x9E3779B97F4A7C15ULL + static_cast<std::uint32_t>(key.y);
  h = h * 0x9E3779B97F4A7C15ULL + static_cast<std::uint32_t>(key.z);
  return static_cast<std::size_t>(h ^ (h >> 29));
}

const CellMembers* SurfaceStore::Find(const CellKey& key) const {
  const auto found = cells_.find(key);
  return found == cells_.end() ? nullptr : &found->second;
}

void SurfaceStore::Fold(const CellKey& key) {
  const auto found = cells_.find(key);
  if (found == cells_.end()) return;
  found->second.folded = true;
  for (Member& member : found->second.members) {
    footprint_bytes_ -= FootprintBytes(member);
    member.footprints = std::vector<SmallFootprint>();  // gives the room back, as {} would not
  }
}

std::vector<Member> SurfaceStore::TakeOut(const CellKey& key) {
  const auto found = cells_.find(key);
  if (found == cells_.end()) return {};
  std::vector<Member> members = std::move(found->second.members);
  cells_.erase(found);
  for (const Member& member : members) {
    footprint_bytes_ -= FootprintBytes(member);
    if (member.surface == kNoSurface) continue;
    surfaces_.at(member.surface).cells.erase(key);
    touched_.insert(member.surface);
  }
  return members;
}

MemberRef SurfaceStore::Add(const CellKey& key, const Eigen::Vector3d& centre_world, const Patch& patch) {
  CellMembers& cell = cells_[key];
  cell.centre_world = centre_world;
  cell.members.push_back(MakeMember(patch, centre_world));
  footprint_bytes_ += FootprintBytes(cell.members.back());
  return {key, static_cast<int>(cell.members.size()) - 1};
}

MemberRef SurfaceStore::AddFolded(const CellKey& key, const Eigen::Vector3d& centre_world,
                                  const Patch& patch) {
  const bool is_new = !cells_.contains(key);
  const MemberRef ref = Add(key, centre_world, patch);
  if (is_new) cells_.at(key).folded = true;
  return ref;
}

void SurfaceStore::Join(const MemberRef& ref, SurfaceId id) {
  At(ref).surface = id;
  Surface& surface = surfaces_.at(id);
  surface.cells.insert(ref.cell);
  surface.box_world.extend(Eigen::AlignedBox3d(At(ref).low_world, At(ref).high_world));
  OpenEvidence(cells_.at(ref.cell), At(ref), &surface);
  touched_.insert(id);
}

void SurfaceStore::Leave(const MemberRef& ref) {
  const CellMembers& cell = cells_.at(ref.cell);
  const SurfaceId id = std::exchange(At(ref).surface, kNoSurface);
  touched_.insert(id);
  const auto is_here = [&](const Member& member) { return member.surface == id; };
  if (std::none_of(cell.members.begin(), cell.members.end(), is_here)) surfaces_.at(id).cells.erase(ref.cell);
}

void SurfaceStore::Found(const MemberRef& ref) {
  const Member& member = At(ref);
  const SurfaceId id = next_surface_++;
  Surface& surface = Begin(id);
  surface.plane_world = member.patch.plane_world;
  surface.angle_sigma_rad = member.angle_sigma_rad;
  surface.noise_m = member.patch.noise_m;
  surface.origin_world = member.mean_world;
  surface.anchor_normal = surface.plane_world.normal;
  surface.axes = AxesOf(surface.anchor_normal);
  Join(ref, id);
}

Surface& SurfaceStore::Begin(SurfaceId id) {
  Surface& surface = surfaces_[id];
  surface.evidence = EvidenceGrid(cell_m_);
  return surface;
}

void SurfaceStore::Remove(SurfaceId id) {
  for (const CellKey& key : surfaces_.at(id).cells) {
    const auto cell = cells_.find(key);
    std::erase_if(cell->second.members, [&](const Member& member) {
      if (member.surface != id) return false;
      footprint_bytes_ -= FootprintBytes(member);
      return true;
    });
    if (cell->second.members.empty()) cells_.erase(cell);
  }
  surfaces_.erase(id);
  touched_.erase(id);
}

void SurfaceStore::Absorb(SurfaceId keep, SurfaceId lose) {
  Surface& winner = surfaces_.at(keep);
  Surface& loser = surfaces_.at(lose);
  for (const CellKey& key : loser.cells) {
    winner.cells.insert(key);
    CellMembers& cell = cells_.at(key);
    for (Member& member : cell.members) {
      if (member.surface != lose) continue;
      member.surface = keep;
      OpenEvidence(cell, member, &winner);
    }
  }
  // Its polygons' ids may live on.
  winner.polygons.insert(winner.polygons.end(), loser.polygons.begin(), loser.polygons.end());
  winner.trace_now = winner.trace_now || !loser.polygons.empty();
  winner.box_world.extend(loser.box_world);
  winner.num_flipped += AdoptEvidence(loser.Frame(), loser.evidence, &winner);
  surfaces_.erase(lose);
  touched_.erase(lose);
  touched_.insert(keep);
  Refit(keep, &winner);
}

void SurfaceStore::RefitTouched() {
  for (const SurfaceId id : touched_)
    if (const auto found = surfaces_.find(id); found != surfaces_.end()) Refit(id, &found->second);
}

/// Sums the moments of all patches anew: cheap, and nothing accumulates.
void SurfaceStore::Refit(SurfaceId id, Surface* surface) {
  PlaneMoments moments;
  double noise2 = 0.0;
  surface->area_m2 = 0.0;
  for (const CellKey& key : surface->cells) {
    const CellMembers& cell = cells_.at(key);
    for (const Member& member : cell.members) {
      if (member.surface != id) continue;
      surface->area_m2 += member.patch.area_m2;
      moments.Add(member.patch.moments, cell.centre_world - surface->origin_world);
      noise2 += member.patch.moments.weight * member.patch.noise_m * member.patch.noise_m;
    }
  }
  surface->moments = moments;
  if (!(moments.weight > 0.0)) return;
  surface->plane_world = moments.Fit(surface->plane_world.normal);
  surface->plane_world.offset_m += surface->plane_world.normal.dot(surface->origin_world);
  surface->angle_sigma_rad = AngleSigma(moments);
  surface->noise_m = std::sqrt(noise2 / moments.weight);
  if (surface->plane_world.normal.dot(surface->anchor_normal) < std::cos(kMaxTurn_rad)) Anchor(surface);
}

Neighbours SurfaceStore::NeighboursOf(SurfaceId id) const {
  Neighbours neighbours;
  for (const CellKey& key : surfaces_.at(id).cells) {
    ForEachAround(key, [&](const CellKey&, const CellMembers& cell) {
      for (const Member& member : cell.members)
        if (member.surface != id && member.surface != kNoSurface)
          neighbours[member.surface].extend(Eigen::AlignedBox3d(member.low_world, member.high_world));
    });
  }
  std::erase_if(neighbours, [&](const auto& item) { return surfaces_.at(item.first).polygons.empty(); });
  return neighbours;
}

void SurfaceStore::Reopen(SurfaceId id) {
  Surface& surface = surfaces_.at(id);
  surface.evidence.Close();
  for (const CellKey& key : surface.cells) {
    const CellMembers& cell = cells_.at(key);
    for (const Member& member : cell.members)
      if (member.surface == id) OpenEvidence(cell, member, &surface);
  }
}

std::int64_t SurfaceStore::memory_bytes() const {
  std::size_t bytes = cells_.size() * (sizeof(CellKey) + sizeof(CellMembers));
  std::int64_t evidence_bytes = 0;
  for (const auto& [id, surface] : surfaces_) {
    // A node of a set takes as much again for its pointers; nearly each holds one member.
    bytes += sizeof(surface) + surface.cells.size() * (4 * sizeof(CellKey) + sizeof(Member));
    evidence_bytes += surface.evidence.memory_bytes();
  }
  return static_cast<std::int64_t>(bytes) + evidence_bytes + footprint_bytes_;
}

}  // namespace terrace
