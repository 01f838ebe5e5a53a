// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "labeling/staircase_tracker.h"

namespace terrace {

/// The place of one region in a staircase, and how sure it is.
struct InStaircase {
  std::int64_t id = 0;
  StepPlace place;
  double confidence = 0.0;
};

/// Which regions belong to which staircase.
class StairRegions {
 public:
  /// Follows what the tracker changed last.
  void Update(const StaircaseTracker& tracker);

  const InStaircase* Find(PolygonId region) const;  ///< null: in none
  /// Those that the last update took out of a staircase and put into none.
  const std::vector<PolygonId>& left() const { return left_; }

 private:
  void Take(std::int64_t staircase);

  std::map<PolygonId, InStaircase> by_region_;
  std::map<std::int64_t, std::vector<PolygonId>> of_staircase_;
  std::vector<PolygonId> left_;
};

}  // namespace terrace
