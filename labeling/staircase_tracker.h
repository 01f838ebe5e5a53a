// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/terrain_map.h"
#include "labeling/shape_table.h"
#include "labeling/staircase_finder.h"

namespace terrace {

/// One region's place in a staircase.
struct StepPlace {
  PolygonId region = 0;
  bool riser = false;
  int step_index = 0;
  bool only_evidence = false;  ///< of the step, but no region to step on
};

/// A staircase that has been seen often enough to be told.
struct TrackedStaircase {
  std::int64_t id = 0;
  FoundStaircase found;           ///< its indices mean nothing any more: `places` says which regions
  std::vector<StepPlace> places;  ///< ascending by region
  PolygonId foot_region = 0;      ///< 0: not seen
  PolygonId head_region = 0;      ///< 0: not seen
  Staircase published;
};

/// Gives staircases stable ids: one appears after it has been found in some frames in a row, survives some in
/// which it is not found, and its numbers rest while they change by less than can be told apart. Those of
/// which a frame shows and changes nothing sleep, and cost nothing.
class StaircaseTracker {
 public:
  explicit StaircaseTracker(int num_frames) : num_frames_(num_frames) {}

  /// The laws of the staircases that have been told, for StaircaseFinder::Find.
  /// Those of which nothing is looked at now are left out.
  std::vector<FlightModel> Models(const ShapeTable& table);

  /// @param found  among the shapes of the table that are looked at; staircases elsewhere stay as they are
  void Update(const std::vector<FoundStaircase>& found, const ShapeTable& table);

  /// True when the last update found another law, or more steps, where a flight is told: whether that is
  /// right needs frames in a row.
  bool contested() const;

  /// By id. No region is in two of them.
  const std::map<std::int64_t, TrackedStaircase>& confirmed() const { return confirmed_; }
  /// Those of them that may have changed with the last update, ascending by id; the others are as they were.
  const std::vector<const TrackedStaircase*>& looked_at() const { return looked_at_; }
  /// Ids of those that the last update found to be gone, ascending.
  const std::vector<std::int64_t>& removed() const { return removed_; }

 private:
  using Serial = std::int64_t;  ///< in the order in which they were first found
  struct Track {
    TrackedStaircase staircase;
    int num_found = 0;   ///< in a row
    double doubt = 1.0;  ///< chance that all of these frames were wrong
    int num_missed = 0;  ///< in a row
    bool told = false;
    bool away = false;        ///< none of its regions is looked at
    bool rests = false;       ///< found now, but not believed: places stay as they were
    int num_other_law = 0;    ///< frames in a row that contradicted what is told
    int num_other_count = 0;  ///< frames in a row that counted `other_count` steps from `other_below` on
    int other_count = 0;
    int other_below = 0;
  };
  /// Wakes those one of whose regions, floor and landing included, is looked at or has gone.
  void Wake(const ShapeTable& table);
  void PutToSleep(const ShapeTable& table);
  void Confirm(Track* track, const ShapeTable& table);
  void ForgetGone();
  /// Takes over what was found now, as far as it is believed.
  void Adopt(Track& track, FoundStaircase now) const;
  void Match(const std::vector<FoundStaircase>& found, const std::vector<RegionShapePtr>& shapes);
  void TakePlaces(const ShapeTable& table);

  int num_frames_;
  std::int64_t last_id_ = 0;
  Serial last_serial_ = 0;
  std::map<Serial, Track> tracks_;  ///< awake
  std::map<Serial, Track> asleep_;
  std::multimap<PolygonId, Serial> asleep_by_region_;
  std::map<std::int64_t, TrackedStaircase> confirmed_;
  std::vector<const TrackedStaircase*> looked_at_;
  std::vector<std::int64_t> removed_;
};

}  // namespace terrace
