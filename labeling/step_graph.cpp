// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/step_graph.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

/// The best link between a vertex of `a` and the area of `b`, over all vertices of `a`.
Link LinkFromVertices(const RegionShape& a, const RegionShape& b, const StepLimits& limits) {
  Link best = Link::kNone;
  for (const PlanRing& ring : a.plan) {
    for (const Eigen::Vector2d& p : ring) {
      const Eigen::Vector2d low = b.bounds.min().head<2>() - p;
      const Eigen::Vector2d high = p - b.bounds.max().head<2>();
      if (std::max(low.maxCoeff(), high.maxCoeff()) > limits.max_reach_m) continue;
      Eigen::Vector2d q;
      const double gap = b.PlanDistance(p, &q);
      if (gap > limits.max_reach_m) continue;
      const double height = std::abs(a.HeightAt(p) - b.HeightAt(q));
      if (gap <= limits.max_joint_gap_m && height <= limits.max_joint_height_m) return Link::kJoins;
      if (height <= limits.max_height_m) best = Link::kStep;
    }
  }
  return best;
}

bool MayTouch(const RegionShape& a, const RegionShape& b, const StepLimits& limits) {
  const Eigen::Vector3d reach(limits.max_reach_m, limits.max_reach_m, limits.max_height_m);
  const Eigen::AlignedBox3d wide(a.bounds.min() - reach, a.bounds.max() + reach);
  return wide.intersects(b.bounds);
}

}  // namespace

Link LinkBetween(const RegionShape& a, const RegionShape& b, const StepLimits& limits) {
  if (!MayTouch(a, b, limits)) return Link::kNone;
  const Link there = LinkFromVertices(a, b, limits);
  if (there == Link::kJoins) return there;
  return std::max(there, LinkFromVertices(b, a, limits));
}

void StepGraph::Update(const std::vector<RegionShapePtr>& shapes) {
  std::map<std::pair<PolygonId, PolygonId>, KnownLink> known;
  neighbors_.assign(shapes.size(), {});
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    if (shapes[i]->lean != Lean::kSupport) continue;
    for (int j = i + 1; j < static_cast<int>(shapes.size()); ++j) {
      if (shapes[j]->lean != Lean::kSupport || !MayTouch(*shapes[i], *shapes[j], limits_)) continue;
      const std::pair key(shapes[i]->id(), shapes[j]->id());
      const auto before = known_.find(key);
      KnownLink& link = known[key];
      if (before != known_.end() && before->second.a == shapes[i] && before->second.b == shapes[j])
        link = before->second;
      else
        link = {shapes[i], shapes[j], LinkBetween(*shapes[i], *shapes[j], limits_)};
      if (link.link == Link::kNone) continue;
      neighbors_[i].emplace_back(j, link.link);
      neighbors_[j].emplace_back(i, link.link);
    }
  }
  known_ = std::move(known);
}

std::vector<bool> StepGraph::Reachable(const std::vector<int>& seeds,
                                       const std::vector<std::pair<int, int>>& extra) const {
  std::vector<bool> reached(neighbors_.size(), false);
  std::vector<int> open = seeds;
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    if (reached[i]) continue;
    reached[i] = true;
    for (const auto& [j, link] : neighbors_[i]) open.push_back(j);
    for (const auto& [a, b] : extra) {
      if (a == i) open.push_back(b);
      if (b == i) open.push_back(a);
    }
  }
  return reached;
}

}  // namespace terrace
