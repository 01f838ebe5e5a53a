// SPDX-License-Identifier: BSD-3-Clause
#include "client/staircase_steps.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

/// Where the noses of a flight are, by its law.
class NoseLaw {
 public:
  explicit NoseLaw(const Staircase& stairs) : stairs_(stairs) {
    if (!turns()) return;
    // The head edge is the foot edge turned about the axis: head = c + R (foot - c).
    const Eigen::Matrix2d R = Eigen::Rotation2Dd(Turn(stairs.num_risers)).toRotationMatrix();
    const Eigen::Vector2d foot = Middle(stairs.foot_edge_world);
    axis_ = (Eigen::Matrix2d::Identity() - R).inverse() * (Middle(stairs.head_edge_world) - R * foot);
  }

  /// The nose above riser k: end 0 left, 1 right.
  Eigen::Vector3d Nose(int k, std::size_t end) const {
    const Eigen::Vector3d& foot = stairs_.foot_edge_world[end];
    const double share = stairs_.num_risers > 1 ? (k - 1.0) / (stairs_.num_risers - 1.0) : 0.0;
    Eigen::Vector3d nose = foot + share * (stairs_.head_edge_world[end] - foot);
    if (turns()) nose.head<2>() = axis_ + Eigen::Rotation2Dd(Turn(k)) * (foot.head<2>() - axis_);
    nose.z() = foot.z() + k * stairs_.riser_m;
    return nose;
  }

  /// Unit, up the stairs at riser k.
  Eigen::Vector2d Up(int k) const {
    return Eigen::Rotation2Dd(Turn(k)) * stairs_.direction_up_world.head<2>().normalized();
  }

 private:
  static Eigen::Vector2d Middle(const std::array<Eigen::Vector3d, 2>& edge) {
    return 0.5 * (edge[0] + edge[1]).head<2>();
  }
  bool turns() const { return std::abs(stairs_.turn_per_step_rad) > 1e-6; }
  double Turn(int k) const { return stairs_.turn_per_step_rad * (k - 1); }

  const Staircase& stairs_;
  Eigen::Vector2d axis_ = Eigen::Vector2d::Zero();
};

/// The largest region of the staircase that is its step k; null: there is none.
const TerrainQuery::Entry* RegionOf(const TerrainQuery& query, const Staircase& stairs, int k) {
  const TerrainQuery::Entry* found = nullptr;
  for (const std::int64_t id : stairs.region_ids) {
    const TerrainQuery::Entry* entry = query.Find(id);
    if (!entry || !entry->shape->carries() || entry->region->step_index != k) continue;
    if (!found || entry->region->area_m2 > found->region->area_m2) found = entry;
  }
  return found;
}

StairStep StepAt(const TerrainQuery& query, const Staircase& stairs, const NoseLaw& law, int k) {
  StairStep step;
  step.index = k;
  step.landing = k > stairs.num_treads;
  step.nose_world = {law.Nose(k, 0), law.Nose(k, 1)};
  step.depth_m = stairs.tread_m;
  step.depth_sigma_m = stairs.tread_sigma_m;
  step.width_m = (step.nose_world[0] - step.nose_world[1]).norm();
  step.sigma_height_m = k * stairs.riser_sigma_m;  // all risers are off by the same
  if (const TerrainQuery::Entry* entry = RegionOf(query, stairs, k)) {
    step.region_id = entry->region->id;
    step.seen = !entry->region->predicted();
    if (step.seen) {
      for (Eigen::Vector3d& end : step.nose_world) end.z() = entry->shape->HeightAt(end.head<2>());
      const Eigen::Vector3d middle = 0.5 * (step.nose_world[0] + step.nose_world[1]);
      step.sigma_height_m = entry->shape->SigmaHeight(entry->shape->ToPlane(middle));
    }
  }
  const Eigen::Vector2d up = law.Up(k);
  step.T_world_step.linear() << up.x(), -up.y(), 0.0, up.y(), up.x(), 0.0, 0.0, 0.0, 1.0;
  step.T_world_step.translation() = 0.5 * (step.nose_world[0] + step.nose_world[1]);
  return step;
}

StairStand StandAt(const TerrainQuery& query, const Eigen::Vector3d& edge_world, const Eigen::Vector2d& up,
                   double along_m, double riser_m) {
  StairStand stand;
  stand.point_world = edge_world;
  stand.point_world.head<2>() += along_m * up;
  stand.heading_up = up;
  // Nearer to this level than to the next step's.
  stand.ground = query.SupportAt(stand.point_world.head<2>(), edge_world.z() - 0.5 * riser_m,
                                 edge_world.z() + 0.5 * riser_m);
  if (stand.ground) stand.point_world = stand.ground->point_world;
  return stand;
}

}  // namespace

StairPlan StepsOf(const TerrainQuery& query, const Staircase& stairs, double stand_off_m) {
  const NoseLaw law(stairs);
  StairPlan plan;
  for (int k = 1; k <= stairs.num_risers; ++k) plan.steps.push_back(StepAt(query, stairs, law, k));
  plan.before = StandAt(query, stairs.base_world(), law.Up(1), -stand_off_m, stairs.riser_m);
  if (plan.steps.empty()) return plan;
  plan.after = StandAt(query, plan.steps.back().T_world_step.translation(), law.Up(stairs.num_risers),
                       stand_off_m, stairs.riser_m);
  return plan;
}

}  // namespace terrace
