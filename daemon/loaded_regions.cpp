// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/loaded_regions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/inset.h"
#include "core/plane_rings.h"

namespace terrace {
namespace {

// The same surface: planes that differ by less than this where both are, and by three sigma at least.
constexpr double kMaxTurn_rad = 10.0 * M_PI / 180.0;
constexpr double kMinApart_m = 0.04;
constexpr double kMaxApart_m = 0.08;  // below the lowest step that matters
// Outlines of what is seen and of what is remembered differ; what is left between them is no ground.
constexpr double kRagged_m = 0.02;
constexpr double kMinArea_m2 = 0.01;
// Vertices come out of the clipping on a grid of micrometres.
constexpr double kSameEdge_m = 1e-4;

double SigmaOffset(const TerrainRegion& region) { return std::sqrt(region.plane_covariance(2, 2)); }

std::vector<FlatRing> Projected(const TerrainRegion& region, const RegionShape& onto) {
  std::vector<FlatRing> rings;
  const auto add = [&](const Ring& ring_world) {
    FlatRing& ring = rings.emplace_back();
    for (const Eigen::Vector3d& p : ring_world) ring.push_back(onto.ToPlane(p));
  };
  add(region.outline_world);
  for (const Ring& hole : region.holes_world) add(hole);
  return rings;
}

/// An outline and the holes in it.
struct Piece {
  FlatRing outline;
  std::vector<FlatRing> holes;
  double area_m2 = 0.0;
};

/// The largest first; those too small or too thin to mean anything are left out.
std::vector<Piece> PiecesOf(const FlatPolygon& polygon) {
  std::vector<Piece> pieces;
  for (const FlatRing& ring : polygon.rings()) {
    const double area_m2 = SignedArea(ring);
    if (area_m2 > 0.0) pieces.push_back({ring, {}, area_m2});
  }
  for (const FlatRing& ring : polygon.rings()) {
    if (SignedArea(ring) >= 0.0) continue;
    // Outlines can lie in holes: the smallest around it is its own.
    Piece* own = nullptr;
    for (Piece& piece : pieces) {
      const bool smaller = own == nullptr || SignedArea(piece.outline) < SignedArea(own->outline);
      if (smaller && FlatPolygon({piece.outline}).Contains(ring.front())) own = &piece;
    }
    if (own == nullptr) continue;
    own->holes.push_back(ring);
    own->area_m2 += SignedArea(ring);
  }
  std::erase_if(pieces, [](const Piece& piece) {
    if (piece.area_m2 < kMinArea_m2) return true;
    std::vector<FlatRing> rings{piece.outline};
    rings.insert(rings.end(), piece.holes.begin(), piece.holes.end());
    const FlatPolygon whole(std::move(rings));
    const std::vector<RegionEdge> edges(whole.num_edges());
    return InsetOf(whole, edges, {kRagged_m, 0.0, 0.0}).empty();
  });
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.area_m2 > b.area_m2; });
  return pieces;
}

/// What lies beyond an edge of what is left: as before where it was an edge before, else what was seen.
RegionEdge EdgeBetween(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const RegionShape& before) {
  const FlatPolygon::Approach nearest = before.polygon().NearestEdge(0.5 * (a + b));
  if (nearest.distance_m < kSameEdge_m) return before.edge(nearest.edge);
  return {EdgeKind::kJoins, std::nullopt, std::nullopt};
}

std::shared_ptr<TerrainRegion> RegionOf(const Piece& piece, const TerrainRegion& whole,
                                        const RegionShape& shape) {
  auto region = std::make_shared<TerrainRegion>(whole);
  region->area_m2 = piece.area_m2;
  region->edges.clear();
  const auto lift = [&](const FlatRing& ring) {
    Ring ring_world;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      ring_world.push_back(shape.ToWorld(ring[i]));
      region->edges.push_back(EdgeBetween(ring[i], ring[(i + 1) % ring.size()], shape));
    }
    return ring_world;
  };
  region->outline_world = lift(piece.outline);
  region->holes_world.clear();
  for (const FlatRing& hole : piece.holes) region->holes_world.push_back(lift(hole));
  return region;
}

/// Whether two regions that may overlap are the same surface.
bool SameSurface(const TerrainRegion& a, const TerrainRegion& b, const FlatPolygon& common,
                 const RegionShape& shape_of_a) {
  // Steps that were inferred are known by the law of their staircase alone.
  const double sigma_m = std::hypot(SigmaOffset(a), SigmaOffset(b));
  const bool known = !a.predicted() && !b.predicted() && std::isfinite(sigma_m);
  const double apart_m = known ? std::clamp(3.0 * sigma_m, kMinApart_m, kMaxApart_m) : kMaxApart_m;
  for (const FlatRing& ring : common.rings()) {
    for (const Eigen::Vector2d& p : ring) {
      if (std::abs(b.plane_world.SignedDistance(shape_of_a.ToWorld(p))) > apart_m) return false;
    }
  }
  return true;
}

/// Everything that can be the same surface.
Eigen::AlignedBox3d Around(const TerrainRegion& region) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : region.outline_world) box.extend(p);
  const Eigen::Vector3d apart = Eigen::Vector3d::Constant(kMaxApart_m);
  return {box.min() - apart, box.max() + apart};
}

}  // namespace

LoadedRegions::LoadedRegions(const std::vector<TerrainRegion>& regions_world) {
  for (const TerrainRegion& region : regions_world) {
    left_[region.id] = {std::make_shared<const TerrainRegion>(region),
                        std::make_shared<const RegionShape>(region)};
  }
  next_piece_id_ = left_.empty() ? 1 : left_.rbegin()->first + 1;
  first_free_id_ = next_piece_id_ + kRoomForPieces;
}

FlatPolygon LoadedRegions::Shared(const Left& left, const TerrainRegion& other) {
  if (other.plane_world.normal.dot(left.shape->normal_world()) < std::cos(kMaxTurn_rad)) return {};
  FlatPolygon common = Within(left.shape->polygon(), Projected(other, *left.shape));
  return SameSurface(*left.region, other, common, *left.shape) ? std::move(common) : FlatPolygon();
}

void LoadedRegions::TakeAway(const TerrainRegion& seen) {
  const Eigen::AlignedBox3d box = Around(seen);
  std::vector<std::pair<std::int64_t, FlatPolygon>> rests;
  for (const auto& [id, left] : left_) {
    if (!left.shape->box_world().intersects(box)) continue;
    // What is only inferred takes nothing away from what was seen.
    if (seen.predicted() && !left.region->predicted()) continue;
    if (!Shared(left, seen).empty())
      rests.emplace_back(id, Without(left.shape->polygon(), Projected(seen, *left.shape)));
  }
  for (const auto& [id, rest] : rests) Replace(id, rest);
}

bool LoadedRegions::Shows(const TerrainRegion& predicted) const {
  const Eigen::AlignedBox3d box = Around(predicted);
  double shared_m2 = 0.0;
  for (const auto& [id, left] : left_) {
    if (left.region->predicted() || !left.shape->box_world().intersects(box)) continue;
    shared_m2 += Shared(left, predicted).area_m2();
  }
  return shared_m2 > 0.5 * predicted.area_m2;
}

void LoadedRegions::Replace(std::int64_t id, const FlatPolygon& rest) {
  const Left whole = left_[id];
  left_.erase(id);
  bool largest = true;
  for (const Piece& piece : PiecesOf(rest)) {
    if (!largest && next_piece_id_ >= first_free_id_) return;
    auto region = RegionOf(piece, *whole.region, *whole.shape);
    if (largest) {
      ++region->revision;
    } else {
      region->id = next_piece_id_++;
      region->revision = 1;
    }
    largest = false;
    left_[region->id] = {region, std::make_shared<const RegionShape>(*region)};
  }
}

std::vector<std::shared_ptr<const TerrainRegion>> LoadedRegions::regions() const {
  std::vector<std::shared_ptr<const TerrainRegion>> regions;
  for (const auto& [id, left] : left_) regions.push_back(left.region);
  return regions;
}

}  // namespace terrace
