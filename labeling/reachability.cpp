// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/reachability.h"

#include <algorithm>

#include "labeling/label_rules.h"

namespace terrace {
namespace {

std::vector<std::pair<int, int>> LinksAcrossUnseen(const std::vector<bool>& reachable,
                                                   const std::vector<RegionShapePtr>& shapes,
                                                   const LabelingConfig& config) {
  std::vector<std::pair<int, int>> links;
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    const RegionShape& lost = *shapes[i];
    if (reachable[i] || lost.lean != Lean::kSupport ||
        lost.largest_square_m < 0.5 * config.min_walkway_edge_m)
      continue;
    for (int j = 0; j < static_cast<int>(shapes.size()); ++j) {
      if (!reachable[j] || shapes[j]->largest_square_m < 0.5 * config.min_walkway_edge_m) continue;
      if (!GroundGoesOn(lost, *shapes[j], shapes, config)) continue;
      links.emplace_back(i, j);
      break;
    }
  }
  return links;
}

}  // namespace

std::vector<std::pair<int, int>> StairLinks(const std::vector<const TrackedStaircase*>& staircases,
                                            const ShapeTable& table, const RobotConfig& robot) {
  constexpr double kSlack = 0.02;
  std::vector<std::pair<int, int>> links;
  for (const TrackedStaircase* staircase : staircases) {
    const TrackedStaircase& s = *staircase;
    if (s.published.riser_m > robot.max_step_height_m + kSlack) continue;
    std::vector<std::pair<int, int>> steps;  // step index, shape
    if (const int foot = table.IndexOf(s.foot_region); foot >= 0) steps.emplace_back(0, foot);
    for (const StepPlace& place : s.places)
      if (const int tread = table.IndexOf(place.region); !place.riser && !place.only_evidence && tread >= 0)
        steps.emplace_back(place.step_index, tread);
    if (const int head = table.IndexOf(s.head_region); head >= 0)
      steps.emplace_back(s.published.num_risers, head);
    std::sort(steps.begin(), steps.end());
    for (std::size_t i = 1; i < steps.size(); ++i) links.emplace_back(steps[i - 1].second, steps[i].second);
  }
  return links;
}

std::vector<bool> ReachableFrom(const std::vector<int>& seeds, std::vector<std::pair<int, int>> links,
                                const StepGraph& graph, const std::vector<RegionShapePtr>& shapes,
                                const LabelingConfig& config) {
  std::vector<bool> reachable = graph.Reachable(seeds, links);
  // A chain of such pieces takes as many rounds.
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<std::pair<int, int>> across = LinksAcrossUnseen(reachable, shapes, config);
    if (across.empty()) break;
    links.insert(links.end(), across.begin(), across.end());
    reachable = graph.Reachable(seeds, links);
  }
  return reachable;
}

}  // namespace terrace
