// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "labeling/region_shape.h"

namespace terrace {

/// What lies between two supports.
enum class Link {
  kNone,
  kStep,   ///< a step that the robot can take
  kJoins,  ///< the same ground goes on
};

/// How far the robot steps, and when two pieces are the same ground.
struct StepLimits {
  double max_reach_m = 0.0;
  double max_height_m = 0.0;
  double max_joint_gap_m = 0.0;
  double max_joint_height_m = 0.0;
};

/// The best link that exists between the outlines of two supports.
Link LinkBetween(const RegionShape& a, const RegionShape& b, const StepLimits& limits);

/// Supports as nodes, steps between them as edges. Remembers the links of shapes that did not change.
class StepGraph {
 public:
  explicit StepGraph(const StepLimits& limits) : limits_(limits) {}

  /// @param shapes  ascending by id
  void Update(const std::vector<RegionShapePtr>& shapes);

  /// Pairs of indices into what was last given to Update, each in both directions, ascending.
  const std::vector<std::vector<std::pair<int, Link>>>& neighbors() const { return neighbors_; }

  /// What can be reached from the seeds over links and `extra` pairs.
  std::vector<bool> Reachable(const std::vector<int>& seeds,
                              const std::vector<std::pair<int, int>>& extra) const;

 private:
  struct KnownLink {
    RegionShapePtr a;
    RegionShapePtr b;
    Link link = Link::kNone;
  };
  StepLimits limits_;
  std::map<std::pair<PolygonId, PolygonId>, KnownLink> known_;
  std::vector<std::vector<std::pair<int, Link>>> neighbors_;
};

}  // namespace terrace
