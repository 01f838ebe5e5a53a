// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/surface_pieces.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

namespace terrace {
namespace {

/// A polygon is larger than this many times its noise.
constexpr double kCredibleEdge = 6.0;

/// A member with the middles of its footprints in the axes of the surface.
struct DrawnMember {
  MemberRef ref;
  std::vector<Eigen::Vector2d> centres;
};

struct DrawnSurface {
  std::vector<DrawnMember> members;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
};

Eigen::Vector2d InAxes(const Surface& surface, const Eigen::Vector3d& v) {
  return {surface.axes.x.dot(v), surface.axes.y.dot(v)};
}

DrawnSurface LayOut(SurfaceId id, const SurfaceStore& store) {
  const Surface& surface = store.surfaces().at(id);
  DrawnSurface drawn;
  for (const CellKey& key : surface.cells) {
    const CellMembers& cell = *store.Find(key);
    const Eigen::Vector3d centre = cell.centre_world - surface.origin_world;
    for (int i = 0; i < static_cast<int>(cell.members.size()); ++i) {
      const Member& member = cell.members[static_cast<std::size_t>(i)];
      if (member.surface != id) continue;
      drawn.members.push_back({{key, i}, {}});
      for (const Footprint& f : member.patch.footprints) {
        const Eigen::Vector2d at = InAxes(surface, centre + f.centre.cast<double>());
        const Eigen::Vector2d extent = InAxes(surface, f.half_x.cast<double>()).cwiseAbs() +
                                       InAxes(surface, f.half_y.cast<double>()).cwiseAbs();
        drawn.low = drawn.low.cwiseMin(at - extent);
        drawn.high = drawn.high.cwiseMax(at + extent);
        drawn.members.back().centres.push_back(at);
      }
    }
  }
  return drawn;
}

/// The piece that most of a member's leaves lie in; -1 for none.
int TracedPieceOf(const DrawnMember& drawn, const OutlineTracer& tracer) {
  std::map<int, int> hits;
  for (const Eigen::Vector2d& centre : drawn.centres)
    if (const int piece = tracer.PieceAt(centre); piece >= 0) ++hits[piece];
  int best = -1, most = 0;
  for (const auto& [piece, count] : hits) {
    if (count <= most) continue;
    best = piece;
    most = count;
  }
  return best;
}

}  // namespace

void CutPieces(SurfaceId id, const SurfaceStore& store, const MergingConfig& config,
               std::vector<SurfacePiece>* pieces) {
  const Surface& surface = store.surfaces().at(id);
  const DrawnSurface drawn = LayOut(id, store);
  OutlineTracer tracer({config.outline_resolution_m, config.max_gap_m, config.min_width_m, config.min_area_m2,
                        config.simplify_m, config.max_vertices},
                       drawn.low, drawn.high);
  for (const DrawnMember& d : drawn.members) {
    const Patch& patch = store.At(d.ref).patch;
    for (std::size_t i = 0; i < d.centres.size(); ++i)
      tracer.Fill(d.centres[i], InAxes(surface, patch.footprints[i].half_x.cast<double>()),
                  InAxes(surface, patch.footprints[i].half_y.cast<double>()));
  }
  const double credible_edge = kCredibleEdge * surface.noise_m;
  std::vector<int> piece_of;  // of each that was traced; -1 when it is not published
  for (TracedPiece& traced : tracer.Trace()) {
    if (traced.area_m2 < credible_edge * credible_edge) {
      piece_of.push_back(-1);
      continue;
    }
    piece_of.push_back(static_cast<int>(pieces->size()));
    pieces->emplace_back();
    pieces->back().surface = id;
    pieces->back().traced = std::move(traced);
  }
  for (const DrawnMember& d : drawn.members) {
    const int traced = TracedPieceOf(d, tracer);
    if (traced < 0 || piece_of[static_cast<std::size_t>(traced)] < 0) continue;
    SurfacePiece& piece = (*pieces)[static_cast<std::size_t>(piece_of[static_cast<std::size_t>(traced)])];
    const Member& member = store.At(d.ref);
    if (member.polygon != 0) piece.votes[member.polygon] += member.patch.area_m2;
    piece.members.push_back(d.ref);
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
