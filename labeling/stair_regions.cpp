// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/stair_regions.h"

namespace terrace {

/// Takes out what belonged to a staircase.
void StairRegions::Take(std::int64_t staircase) {
  const auto before = of_staircase_.find(staircase);
  if (before == of_staircase_.end()) return;
  for (const PolygonId region : before->second) {
    by_region_.erase(region);
    left_.push_back(region);
  }
  of_staircase_.erase(before);
}

void StairRegions::Update(const StaircaseTracker& tracker) {
  left_.clear();
  for (const std::int64_t id : tracker.removed()) Take(id);
  for (const TrackedStaircase* s : tracker.looked_at()) Take(s->id);
  for (const TrackedStaircase* s : tracker.looked_at()) {
    std::vector<PolygonId>& regions = of_staircase_[s->id];
    for (const StepPlace& place : s->places) {
      if (place.only_evidence) continue;
      by_region_.emplace(place.region, InStaircase{s->id, place, s->published.confidence});
      regions.push_back(place.region);
    }
  }
  std::erase_if(left_, [&](PolygonId region) { return by_region_.contains(region); });
}

const InStaircase* StairRegions::Find(PolygonId region) const {
  const auto found = by_region_.find(region);
  return found == by_region_.end() ? nullptr : &found->second;
}

}  // namespace terrace
