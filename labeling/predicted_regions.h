// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "core/terrain_map.h"
#include "labeling/inferred_steps.h"
#include "labeling/shape_table.h"
#include "labeling/staircase_tracker.h"

namespace terrace {

/// The inferred steps of all staircases as regions of the map, with ids and revisions of their own.
class PredictedRegions {
 public:
  /// @param cap  no label is more certain
  void Update(const std::vector<TrackedStaircase>& staircases, const ShapeTable& table, double cap);

  /// Ascending by id, and all ids above those of polygons.
  const std::vector<std::shared_ptr<const TerrainRegion>>& regions() const { return regions_; }

 private:
  using Key = std::tuple<std::int64_t, int, bool>;  ///< staircase, step, riser
  struct Basis {
    FlightModel model;
    int num_risers = 0;
    std::size_t num_places = 0;
    double confidence = 0.0;
  };
  /// True when nothing that its steps follow from has changed.
  bool Rests(const TrackedStaircase& staircase, const ShapeTable& table) const;
  void Infer(const TrackedStaircase& staircase, const ShapeTable& table, double cap);

  /// Polygons count from 1, and never come so far.
  std::int64_t last_id_ = 1'000'000'000;
  std::map<Key, std::shared_ptr<const TerrainRegion>> told_;
  std::map<std::int64_t, Basis> bases_;  ///< by staircase
  std::vector<std::shared_ptr<const TerrainRegion>> regions_;
};

}  // namespace terrace
