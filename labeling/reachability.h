// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "labeling/labeling_config.h"
#include "labeling/shape_table.h"
#include "labeling/staircase_tracker.h"
#include "labeling/step_graph.h"

namespace terrace {

/// Pairs of shapes that a staircase joins, although a step between them may not have been seen.
std::vector<std::pair<int, int>> StairLinks(const std::vector<const TrackedStaircase*>& staircases,
                                            const ShapeTable& table, const RobotConfig& robot);

/// What the robot can come to from the seeds: over steps it can take, along `links`, and along ground that
/// goes on behind a strip that was not seen.
std::vector<bool> ReachableFrom(const std::vector<int>& seeds, std::vector<std::pair<int, int>> links,
                                const StepGraph& graph, const std::vector<RegionShapePtr>& shapes,
                                const LabelingConfig& config);

}  // namespace terrace
