// SPDX-License-Identifier: BSD-3-Clause
#include "client/example/footsteps/footstep_search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

namespace terrace {
namespace {

constexpr double kArrived_m = 0.2;    // from the goal, in the plan
constexpr double kStepCost_m = 0.02;  // of each step: fewer are better
constexpr double kHeightCost = 0.5;   // of a metre up or down, in metres
constexpr double kCell_m = 0.08;      // feet that stand nearer together than this are the same state
// Plans may cost this much more than the best one, and are found so much sooner.
constexpr double kHaste = 1.5;

/// A step of the plan as the search has it: one foot has just been set, the other one is next.
struct Node {
  Footstep step;
  int before = -1;
  double cost_m = 0.0;
};

using StateKey = std::tuple<long, long, long, int, bool>;

StateKey KeyOf(const Footstep& step, double turn_rad) {
  const Eigen::Vector3d cell = step.ground.point_world / kCell_m;
  return {std::lround(cell.x()), std::lround(cell.y()), std::lround(cell.z()),
          static_cast<int>(std::lround(std::remainder(step.heading_rad, 2.0 * M_PI) / turn_rad)), step.left};
}

class Search {
 public:
  Search(const TerrainQuery& query, const Walker& walker, const PlanEnd& goal)
      : query_(query), walker_(walker), goal_(goal) {}

  std::vector<Footstep> Run(const PlanEnd& start, int max_expansions) {
    const auto left = SetFoot(start.ground_world, start.heading_rad, true, 0.5 * walker_.stance_width_m, 0.0);
    const auto right =
        SetFoot(start.ground_world, start.heading_rad, false, 0.5 * walker_.stance_width_m, 0.0);
    if (!left || !right) return {};
    nodes_.push_back({*left, -1, 0.0});
    Add({*right, 0, 0.0});
    while (!open_.empty() && closed_.size() < static_cast<std::size_t>(max_expansions)) {
      const int best = open_.top().second;
      open_.pop();
      if (!closed_.emplace(KeyOf(At(best).step, walker_.turn_rad), best).second) continue;
      if (Arrived(At(best).step)) return StepsTo(best);
      Expand(best);
    }
    return {};
  }

 private:
  const Node& At(int i) const { return nodes_[static_cast<std::size_t>(i)]; }

  /// A foot beside and before a place on the ground; none: there is no foothold near enough.
  std::optional<Footstep> SetFoot(const Eigen::Vector3d& from_world, double heading_rad, bool left,
                                  double aside_m, double ahead_m) const {
    const Eigen::Vector2d forward(std::cos(heading_rad), std::sin(heading_rad));
    const Eigen::Vector2d to_left(-forward.y(), forward.x());
    Eigen::Vector3d nominal_world = from_world;
    nominal_world.head<2>() += ahead_m * forward + (left ? aside_m : -aside_m) * to_left;
    const auto foothold =
        query_.NearestFoothold(nominal_world, walker_.snap_m, walker_.max_step_height_m, walker_.foot);
    if (!foothold) return std::nullopt;
    return Footstep{left, heading_rad, foothold->support};
  }

  /// The middle of the walker that stands on a foot.
  Eigen::Vector2d MiddleOf(const Footstep& step) const {
    const Eigen::Vector2d to_left(-std::sin(step.heading_rad), std::cos(step.heading_rad));
    return step.ground.point_world.head<2>() + (step.left ? -0.5 : 0.5) * walker_.stance_width_m * to_left;
  }

  /// All the way from where the walker stands to where the step takes it.
  bool BodyIsClear(const Footstep& stance, const Footstep& step) const {
    const double z = std::max(stance.ground.point_world.z(), step.ground.point_world.z());
    Eigen::AlignedBox2d way(MiddleOf(stance));
    way.extend(MiddleOf(step));
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(walker_.body_half_width_m);
    const Eigen::Vector2d low = way.min() - half, high = way.max() + half;
    return query_
        .RegionsIn({Eigen::Vector3d(low.x(), low.y(), z + walker_.body_bottom_m),
                    Eigen::Vector3d(high.x(), high.y(), z + walker_.body_top_m)})
        .empty();
  }

  void Expand(int from) {
    const Footstep stance = At(from).step;
    for (const double turn : {0.0, -walker_.turn_rad, walker_.turn_rad}) {
      for (const double share : {1.0, 0.6, 0.3, 0.0}) {
        const double heading = stance.heading_rad + turn;
        const auto step = SetFoot(stance.ground.point_world, heading, !stance.left, walker_.stance_width_m,
                                  share * walker_.stride_m);
        if (!step || !BodyIsClear(stance, *step)) continue;
        const double climb_m = std::abs(step->ground.point_world.z() - stance.ground.point_world.z());
        const double way_m = (MiddleOf(*step) - MiddleOf(stance)).norm();
        Add({*step, from, At(from).cost_m + way_m + kStepCost_m + kHeightCost * climb_m});
      }
    }
  }

  void Add(const Node& node) {
    nodes_.push_back(node);
    const double left_m = (MiddleOf(node.step) - goal_.ground_world.head<2>()).norm();
    const double climb_m = std::abs(node.step.ground.point_world.z() - goal_.ground_world.z());
    const double at_least_m =
        left_m + kStepCost_m * left_m / (walker_.stride_m + walker_.snap_m) + kHeightCost * climb_m;
    open_.emplace(-(node.cost_m + kHaste * at_least_m), static_cast<int>(nodes_.size()) - 1);
  }

  bool Arrived(const Footstep& step) const {
    return (MiddleOf(step) - goal_.ground_world.head<2>()).norm() <= kArrived_m &&
           std::abs(step.ground.point_world.z() - goal_.ground_world.z()) <= walker_.max_step_height_m;
  }

  std::vector<Footstep> StepsTo(int node) const {
    std::vector<Footstep> steps;
    for (; node >= 0; node = At(node).before) steps.push_back(At(node).step);
    std::reverse(steps.begin(), steps.end());
    return steps;
  }

  const TerrainQuery& query_;
  const Walker& walker_;
  const PlanEnd& goal_;
  std::vector<Node> nodes_;
  std::priority_queue<std::pair<double, int>> open_;
  std::map<StateKey, int> closed_;
};

}  // namespace

std::vector<Footstep> PlanFootsteps(const TerrainQuery& query, const Walker& walker, const PlanEnd& start,
                                    const PlanEnd& goal, int max_expansions) {
  return Search(query, walker, goal).Run(start, max_expansions);
}

}  // namespace terrace
