// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
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
  void Update(const StaircaseTracker& tracker, const ShapeTable& table, double cap);

  using RegionPtr = std::shared_ptr<const TerrainRegion>;
  /// What the last update made of them, by id; null: gone. All ids are above those of polygons.
  const std::map<std::int64_t, RegionPtr>& changes() const { return changes_; }
  /// Of one staircase, ascending.
  std::vector<std::int64_t> IdsOf(std::int64_t staircase) const;

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
  /// Forgets the steps of a staircase that are not among the demanded.
  void ForgetOthers(std::int64_t staircase, const std::set<Key>& demanded);

  /// Polygons count from 1, and never come so far.
  std::int64_t last_id_ = 1'000'000'000;
  std::map<Key, RegionPtr> told_;
  std::map<std::int64_t, Basis> bases_;  ///< by staircase
  std::map<std::int64_t, RegionPtr> changes_;
};

}  // namespace terrace
