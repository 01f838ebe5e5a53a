// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_store.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace terrace {
namespace {

/// The axes of a surface's outline are laid anew when its normal has turned by this much.
constexpr double kMaxTurn_rad = 0.03;

/// Standard deviation of the normal that moments alone support, across the narrow side of the patch.
double AngleSigma(const PlaneMoments& moments) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(moments.Covariance(), Eigen::EigenvaluesOnly);
  const double width2 = std::max(solver.eigenvalues()(1), 1e-8);
  return std::sqrt((1.0 / moments.weight + kSystematic_m * kSystematic_m) / width2);
}

Member MakeMember(const Patch& patch, const Eigen::Vector3d& centre_world) {
  Member member;
  member.patch = patch;
  member.mean_world = centre_world + patch.moments.Mean();
  member.low_world.setConstant(std::numeric_limits<double>::infinity());
  member.high_world = -member.low_world;
  for (const Footprint& f : patch.footprints) {
    const Eigen::Vector3d at = centre_world + f.centre.cast<double>();
    const Eigen::Vector3d extent = (f.half_x.cwiseAbs() + f.half_y.cwiseAbs()).cast<double>();
    member.low_world = member.low_world.cwiseMin(at - extent);
    member.high_world = member.high_world.cwiseMax(at + extent);
  }
  member.angle_sigma_rad = AngleSigma(patch.moments);
  return member;
}

std::int64_t BytesOf(const Member& member) {
  return static_cast<std::int64_t>(sizeof(Member) + member.patch.footprints.size() * sizeof(Footprint));
}

void Anchor(Surface* surface) {
  surface->anchor_normal = surface->plane_world.normal;
  surface->axes = AxesOf(surface->anchor_normal);
  surface->trace_now = true;
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

std::vector<Member> SurfaceStore::TakeOut(const CellKey& key) {
  const auto found = cells_.find(key);
  if (found == cells_.end()) return {};
  std::vector<Member> members = std::move(found->second.members);
  cells_.erase(found);
  for (const Member& member : members) {
    member_bytes_ -= BytesOf(member);
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
  member_bytes_ += BytesOf(cell.members.back());
  return {key, static_cast<int>(cell.members.size()) - 1};
}

void SurfaceStore::Join(const MemberRef& ref, SurfaceId id) {
  At(ref).surface = id;
  surfaces_.at(id).cells.insert(ref.cell);
  touched_.insert(id);
}

void SurfaceStore::Found(const MemberRef& ref) {
  const Member& member = At(ref);
  const SurfaceId id = next_surface_++;
  Surface& surface = surfaces_[id];
  surface.plane_world = member.patch.plane_world;
  surface.angle_sigma_rad = member.angle_sigma_rad;
  surface.noise_m = member.patch.noise_m;
  surface.origin_world = member.mean_world;
  Anchor(&surface);
  Join(ref, id);
}

void SurfaceStore::Absorb(SurfaceId keep, SurfaceId lose) {
  Surface& winner = surfaces_.at(keep);
  Surface& loser = surfaces_.at(lose);
  for (const CellKey& key : loser.cells) {
    winner.cells.insert(key);
    for (Member& member : cells_.at(key).members)
      if (member.surface == lose) member.surface = keep;
  }
  // Its polygons' ids may live on.
  winner.polygons.insert(winner.polygons.end(), loser.polygons.begin(), loser.polygons.end());
  winner.trace_now = true;
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
  for (const CellKey& key : surface->cells) {
    const CellMembers& cell = cells_.at(key);
    for (const Member& member : cell.members) {
      if (member.surface != id) continue;
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

std::int64_t SurfaceStore::memory_bytes() const {
  std::size_t bytes = cells_.size() * (sizeof(CellKey) + sizeof(CellMembers));
  for (const auto& [id, surface] : surfaces_)
    bytes += sizeof(surface) + surface.cells.size() * 4 * sizeof(CellKey);
  return static_cast<std::int64_t>(bytes) + member_bytes_;
}

}  // namespace terrace
