// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/far_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "polygonization/outline_evidence.h"

namespace terrace {
namespace {

/// Mean of the cells that belong to the surface.
std::int8_t StrengthOf(const EvidenceGrid& evidence) {
  std::int64_t sum = 0, num = 0;
  for (const auto& [key, block] : evidence.blocks()) {
    for (const std::int8_t cell : block.cells) {
      if (cell < EvidenceGrid::kOn) continue;
      sum += cell;
      ++num;
    }
  }
  return static_cast<std::int8_t>(num > 0 ? sum / num : EvidenceGrid::kOn);
}

FarSurface::Part PartOf(const CellKey& key, const Patch& patch) {
  FarSurface::Part part{key, {}, {}, Eigen::half(static_cast<float>(patch.area_m2))};
  for (std::size_t i = 0; i < 3; ++i) {
    part.low[i] = Eigen::half(patch.low[static_cast<Eigen::Index>(i)]);
    part.high[i] = Eigen::half(patch.high[static_cast<Eigen::Index>(i)]);
  }
  return part;
}

Eigen::Vector3f Floats(const std::array<Eigen::half, 3>& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

/// The patch of a part, taken to lie evenly in its box and in the plane of the surface, so that the sums of
/// all parts have the weight and the plane of the surface's.
/// @param scatter_m2  mean squared distance of the surface's points from its plane
/// @param share       of the weight
Patch PatchOf(const FarSurface& far, const FarSurface::Part& part, const Plane& plane_world,
              const Eigen::Vector3d& cell_centre_world, double scatter_m2, double share) {
  Patch patch;
  patch.plane_world = plane_world;
  patch.area_m2 = static_cast<float>(part.area_m2);
  patch.low = Floats(part.low);
  patch.high = Floats(part.high);
  patch.noise_m = patch.most_noise_m = far.noise_m;
  const Eigen::Vector3d& n = plane_world.normal;
  const Eigen::Matrix3d into_plane = Eigen::Matrix3d::Identity() - n * n.transpose();
  const Eigen::Vector3d size = (patch.high - patch.low).cast<double>();
  const Eigen::Vector3d middle = (0.5F * (patch.low + patch.high)).cast<double>();
  const Eigen::Vector3d mean = plane_world.Project(cell_centre_world + middle) - cell_centre_world;
  // An even spread over a length has a twelfth of its square as variance.
  const Eigen::Matrix3d spread = size.cwiseAbs2().asDiagonal().toDenseMatrix() / 12.0;
  patch.moments.weight = share * far.moments.weight;
  patch.moments.sum = patch.moments.weight * mean;
  patch.moments.sum_outer =
      patch.moments.weight * (mean * mean.transpose() + into_plane * spread * into_plane.transpose() +
                              scatter_m2 * n * n.transpose());
  return patch;
}

/// The piece of which a polygon was made.
TracedPiece PieceOf(const Polygon& polygon, const Surface& surface) {
  const PlaneFrame frame = surface.Frame();
  const auto to_plane = [&](const Ring& ring) {
    Ring2 piece;
    for (const Eigen::Vector3d& p : ring) piece.push_back(frame.ToPlane(p));
    return piece;
  };
  TracedPiece piece;
  piece.outline = to_plane(polygon.outline_world);
  for (const Ring& hole : polygon.holes_world) piece.holes.push_back(to_plane(hole));
  piece.area_m2 = polygon.area_m2 * surface.plane_world.normal.dot(surface.anchor_normal);
  piece.centroid = frame.ToPlane(polygon.centroid_world);
  piece.seen_past = polygon.seen_past;
  piece.support = polygon.support;
  return piece;
}

}  // namespace

FarSurface Remember(SurfaceId id, const SurfaceStore& store) {
  const Surface& surface = store.surfaces().at(id);
  FarSurface far;
  far.origin_world = surface.origin_world;
  far.anchor_normal = surface.anchor_normal;
  far.moments = surface.moments;
  far.noise_m = surface.noise_m;
  far.strength = StrengthOf(surface.evidence);
  far.polygons = surface.polygons;
  for (const CellKey& key : surface.cells)
    for (const Member& member : store.Find(key)->members)
      if (member.surface == id) far.parts.push_back(PartOf(key, member.patch));
  far.parts.shrink_to_fit();
  return far;
}

void BringBack(SurfaceId id, const FarSurface& far, const PolygonMap& polygons, double cell_size_m,
               SurfaceStore* store) {
  const Plane about_origin = far.moments.Fit(far.anchor_normal);
  Surface& surface = store->Begin(id);
  surface.plane_world = about_origin;
  surface.plane_world.offset_m += about_origin.normal.dot(far.origin_world);
  surface.origin_world = far.origin_world;
  surface.anchor_normal = far.anchor_normal;
  surface.axes = AxesOf(far.anchor_normal);
  surface.noise_m = far.noise_m;
  surface.trace_now = false;
  double area_m2 = 0.0;
  for (const FarSurface::Part& part : far.parts) area_m2 += static_cast<float>(part.area_m2);
  const double scatter_m2 = far.moments.MeanSquaredDistance(about_origin);
  for (const FarSurface::Part& part : far.parts) {
    const Eigen::Vector3d centre =
        cell_size_m * (Eigen::Vector3d(part.cell.x, part.cell.y, part.cell.z).array() + 0.5);
    const double share = area_m2 > 0.0 ? static_cast<float>(part.area_m2) / area_m2
                                       : 1.0 / static_cast<double>(far.parts.size());
    const MemberRef ref = store->AddFolded(
        part.cell, centre, PatchOf(far, part, surface.plane_world, centre, scatter_m2, share));
    store->Join(ref, id);
  }
  surface.polygons = far.polygons;
  for (const PolygonId polygon : far.polygons) {
    const PolygonPtr known = polygons.Find(polygon);
    TERRACE_CHECK(known != nullptr, polygon);
    surface.pieces.push_back(PieceOf(*known, surface));
    TakeForSeen(surface.pieces.back(), far.strength, &surface.evidence);
  }
}

}  // namespace terrace
