// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "mapping/leaf_address.h"
#include "polygonization/plane_moments.h"
#include "polygonization/polygon.h"
#include "polygonization/polygon_map.h"
#include "polygonization/surface_store.h"

namespace terrace {

/// What is kept of a surface far away: its plane and how well it is known, where its patches lay, and its
/// polygons, whose outlines stand for all that pixels had shown.
struct FarSurface {
  /// A patch. Half the digits of a float are finer than a tenth of a millimetre here.
  struct Part {
    CellKey cell;
    std::array<Eigen::half, 3> low, high;  ///< box around it, relative to the centre of the cell [m]
    Eigen::half area_m2;
  };
  Eigen::Vector3d origin_world;
  Eigen::Vector3d anchor_normal;
  PlaneMoments moments;  ///< relative to `origin_world`
  double noise_m = 0.0;
  std::int8_t strength = 0;  ///< of the evidence where it was seen, on average
  std::vector<PolygonId> polygons;
  std::vector<Part> parts;  ///< ascending by cell

  std::int64_t memory_bytes() const {
    return static_cast<std::int64_t>(sizeof(FarSurface) + polygons.capacity() * sizeof(PolygonId) +
                                     parts.capacity() * sizeof(Part));
  }
};

/// What is kept of a surface of the store.
FarSurface Remember(SurfaceId id, const SurfaceStore& store);

/// Puts a surface back into the store, as one whose points are forgotten: with its polygons, the same plane,
/// and evidence wherever its outlines say that it was seen.
/// @param polygons     those of the surface are among them
/// @param cell_size_m  edge of the cells that patches are fitted in
void BringBack(SurfaceId id, const FarSurface& far, const PolygonMap& polygons, double cell_size_m,
               SurfaceStore* store);

}  // namespace terrace
