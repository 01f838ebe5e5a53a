// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <vector>

#include "polygonization/merging_config.h"
#include "polygonization/outline_tracer.h"
#include "polygonization/polygon.h"
#include "polygonization/surface_store.h"

namespace terrace {

/// One connected piece of a surface: what is published as a polygon.
struct SurfacePiece {
  SurfaceId surface = kNoSurface;
  TracedPiece traced;
  std::map<PolygonId, double> votes;  ///< area that was part of that polygon before
  std::vector<MemberRef> members;
};

/// Traces the evidence for a surface and appends its pieces.
void CutPieces(SurfaceId id, const Neighbours& neighbours, const SurfaceStore& store,
               const MergingConfig& config, std::vector<SurfacePiece>* pieces);

/// The id of each piece: that of the polygon of which it holds most, ties to the older polygon; 0 where it
/// needs a new one. Ids that are given away leave `free_ids`.
std::vector<PolygonId> ClaimIds(const std::vector<SurfacePiece>& pieces, std::set<PolygonId>* free_ids);

}  // namespace terrace
