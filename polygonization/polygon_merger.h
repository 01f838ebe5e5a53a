// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>

#include "polygonization/cell_modeller.h"
#include "polygonization/evidence_look.h"
#include "polygonization/map_reach.h"
#include "polygonization/merging_config.h"
#include "polygonization/polygon.h"
#include "polygonization/polygon_map.h"

namespace terrace {

/// Keeps the global polygon map: patches of neighbouring cells tell which planes there are, the pixels of
/// each frame where they end. Touches only what changed.
class PolygonMerger {
 public:
  explicit PolygonMerger(const MergingConfig& config, const MapReach& reach = {});
  ~PolygonMerger();

  /// @param view  the frame that the patches were last added to
  PolygonUpdate Merge(const PatchUpdate& patches, const FrameView& view);

  /// A frame shows what the one before has shown: its polygons are seen again, and outlines that waited to be
  /// traced are.
  PolygonUpdate SeeNothingNew(FrameId frame_id, Timestamp t_capture);

  /// The points of these cells are forgotten. Their polygons stay, with their ids, and are taken up again
  /// where as much is seen as before.
  void Fold(const std::vector<CellKey>& cells);

  /// The whole map as it is after the last Merge().
  const PolygonMap& polygons() const;
  std::int64_t memory_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
