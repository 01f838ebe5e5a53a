// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/terrain_map.h"
#include "labeling/label_rules.h"
#include "labeling/stair_regions.h"
#include "polygonization/polygon.h"

namespace terrace {

/// One region as it was last told, and what is on the way to be told of it.
class RegionRecord {
 public:
  /// The verdict to tell: a new label must have been found `frames_to_change` times in a row.
  Verdict Steady(const Verdict& verdict, int frames_to_change);

  /// True when the polygon of the region is another than when it was last told.
  bool OutOfDate(const PolygonPtr& polygon) const { return polygon_ != polygon; }

  /// Tells it: a new revision when anything but a hair of confidence has changed.
  /// @param stairs  null: in no staircase
  void Tell(const PolygonPtr& polygon, const Verdict& verdict, const InStaircase* stairs);

  /// It was in view and has not changed: the region is the same, of the same revision, but seen later. Told
  /// five times a second at most, since each time is a copy. Only where it is told.
  void See(Timestamp t_capture);

  /// It is there, but not worth telling.
  void Withhold() { told_ = false; }
  bool told() const { return told_; }
  const std::shared_ptr<const TerrainRegion>& region() const { return region_; }

  /// That the region was made of; null before it was told.
  const PolygonPtr& polygon() const { return polygon_; }
  /// Of the label that was told.
  const LabelEvidence& evidence() const { return evidence_; }
  TerrainLabel next_label() const { return next_label_; }
  /// Frames in a row that said next_label() instead of the label that was told.
  int num_next() const { return num_next_; }

  /// That are to be told instead of those of the region; none: these still hold.
  std::optional<std::vector<RegionEdge>> new_edges;
  bool edges_stale = true;  ///< something beside the shape has changed since

 private:
  bool told_ = false;
  std::shared_ptr<const TerrainRegion> region_;
  PolygonPtr polygon_;
  LabelEvidence evidence_;
  TerrainLabel next_label_ = TerrainLabel::kUnknown;
  int num_next_ = 0;
  int num_seen_ = 0;  // frames that showed it since it was told
};

}  // namespace terrace
