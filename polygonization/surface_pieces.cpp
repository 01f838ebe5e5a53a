// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_pieces.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "polygonization/edge_evidence.h"
#include "polygonization/plane_bitmap.h"
#include "polygonization/surface_joints.h"

namespace terrace {
namespace {

/// A polygon is larger than this many times its noise.
constexpr double kCredibleEdge = 6.0;
/// What hangs on a larger piece by nothing, and is smaller than this and this share of it, is a crumb: pixels
/// at the foot of another surface that happen to agree with the plane beyond it.
constexpr double kCrumb_m2 = 0.15;
constexpr double kCrumbShare = 0.1;

bool IsCrumb(const TracedPiece& piece, const std::vector<TracedPiece>& pieces) {
  double largest_m2 = 0.0;
  for (const TracedPiece& other : pieces) largest_m2 = std::max(largest_m2, other.area_m2);
  return piece.area_m2 < std::min(kCrumb_m2, kCrumbShare * largest_m2);
}

/// The pieces of before speak for the new ones that lie where they lay: a small piece may hold the middle of
/// none of its patches.
template <typename PieceAt>
void VoteByPlace(const Surface& surface, const PieceAt& piece_at) {
  constexpr std::size_t kSamples = 16;
  for (std::size_t i = 0; i < surface.pieces.size(); ++i) {
    const TracedPiece& before = surface.pieces[i];
    const std::size_t step = before.outline.size() / kSamples + 1;
    const auto num = static_cast<double>((before.outline.size() + step - 1) / step);
    for (std::size_t v = 0; v < before.outline.size(); v += step) {
      // A little inside.
      const Eigen::Vector2d p = before.outline[v] + 0.3 * (before.centroid - before.outline[v]);
      if (SurfacePiece* const piece = piece_at(p)) piece->votes[surface.polygons[i]] += before.area_m2 / num;
    }
  }
}

}  // namespace

void CutPieces(SurfaceId id, const Neighbours& neighbours, const SurfaceStore& store,
               const MergingConfig& config, std::vector<SurfacePiece>* pieces) {
  const Surface& surface = store.surfaces().at(id);
  // A margin, so that closing never meets the border.
  const int margin_px = static_cast<int>(std::ceil(config.max_gap_m / surface.evidence.cell_m())) + 2;
  PlaneBitmap bitmap = BitmapOf(surface.evidence, margin_px);
  const std::vector<EdgeLine> lines = CutAtJoints(id, neighbours, store, &bitmap);
  OutlineTracer tracer(
      {config.max_gap_m, config.min_width_m, config.min_area_m2, config.simplify_m, config.max_vertices},
      std::move(bitmap));
  const double credible_edge = kCredibleEdge * surface.noise_m;
  std::vector<int> piece_of;  // of each that was traced; -1 when it is not published
  std::vector<TracedPiece> all = tracer.Trace(lines);
  std::vector<bool> crumbs;
  for (const TracedPiece& traced : all) crumbs.push_back(IsCrumb(traced, all));
  for (std::size_t i = 0; i < all.size(); ++i) {
    TracedPiece& traced = all[i];
    if (traced.area_m2 < credible_edge * credible_edge || crumbs[i]) {
      piece_of.push_back(-1);
      continue;
    }
    piece_of.push_back(static_cast<int>(pieces->size()));
    pieces->emplace_back();
    pieces->back().surface = id;
    pieces->back().traced = std::move(traced);
    pieces->back().traced.seen_past = EdgesSeenPast(pieces->back().traced, surface.evidence);
  }
  const auto piece_at = [&](const Eigen::Vector2d& p) -> SurfacePiece* {
    const int traced = tracer.PieceAt(p);
    if (traced < 0 || piece_of[static_cast<std::size_t>(traced)] < 0) return nullptr;
    return &(*pieces)[static_cast<std::size_t>(piece_of[static_cast<std::size_t>(traced)])];
  };
  VoteByPlace(surface, piece_at);
  const PlaneFrame frame = surface.Frame();
  for (const CellKey& key : surface.cells) {
    const std::vector<Member>& members = store.Find(key)->members;
    for (int i = 0; i < static_cast<int>(members.size()); ++i) {
      const Member& member = members[static_cast<std::size_t>(i)];
      if (member.surface != id) continue;
      SurfacePiece* const piece = piece_at(frame.ToPlane(member.mean_world));
      if (piece == nullptr) continue;
      if (member.polygon != 0) piece->votes[member.polygon] += member.patch.area_m2;
      piece->members.push_back({key, i});
    }
  }
}

std::vector<PolygonId> ClaimIds(const std::vector<SurfacePiece>& pieces, std::set<PolygonId>* free_ids) {
  std::vector<std::tuple<double, PolygonId, std::size_t>> claims;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (const auto& [polygon, area] : pieces[i].votes)
      if (free_ids->contains(polygon)) claims.emplace_back(-area, polygon, i);
  std::sort(claims.begin(), claims.end());
  std::vector<PolygonId> ids(pieces.size(), 0);
  for (const auto& [area, polygon, i] : claims) {
    if (ids[i] != 0 || !free_ids->contains(polygon)) continue;
    ids[i] = polygon;
    free_ids->erase(polygon);
  }
  return ids;
}

}  // namespace terrace
