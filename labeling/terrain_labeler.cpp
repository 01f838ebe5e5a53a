// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/terrain_labeler.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/angles.h"
#include "labeling/body_height_check.h"
#include "labeling/drop_view.h"
#include "labeling/edge_kinds.h"
#include "labeling/explanation_words.h"
#include "labeling/kept_evidence.h"
#include "labeling/label_rules.h"
#include "labeling/map_edits.h"
#include "labeling/predicted_regions.h"
#include "labeling/reachability.h"
#include "labeling/region_record.h"
#include "labeling/shape_table.h"
#include "labeling/sight.h"
#include "labeling/stair_landings.h"
#include "labeling/stair_regions.h"
#include "labeling/staircase_tracker.h"
#include "labeling/stance.h"
#include "labeling/step_graph.h"
#include "labeling/view_memory.h"

namespace terrace {
namespace {

RegionShapeLimits ShapeLimitsOf(const LabelingConfig& config, const RobotConfig& robot) {
  return {Radians(robot.max_ramp_slope_deg), Radians(config.min_upright_deg), config.min_walkway_edge_m};
}

StepLimits StepLimitsOf(const LabelingConfig& config, const RobotConfig& robot) {
  return {robot.max_step_reach_m, robot.max_step_height_m, config.max_joint_gap_m, config.max_joint_height_m};
}

StanceLimits StanceLimitsOf(const LabelingConfig& config, const RobotConfig& robot) {
  // Between two steps of a staircase the body is half a step off, and it bounces.
  constexpr double kBounce = 0.05;
  return {robot.body_height_m, config.max_stance_distance_m, 0.5 * robot.max_step_height_m + kBounce};
}

TerrainMapPtr EmptyMap(std::int64_t map_id) {
  auto map = std::make_shared<TerrainMap>();
  map->map_id = map_id;
  return map;
}

}  // namespace

class TerrainLabeler::Impl {
 public:
  Impl(const LabelingConfig& config, const StaircaseConfig& staircases, const RobotConfig& robot,
       const StereoCamera& camera, const std::optional<Eigen::Isometry3d>& T_body_left, std::int64_t map_id)
      : config_(config),
        stairs_(staircases),
        robot_(robot),
        camera_(camera),
        T_left_body_(T_body_left ? T_body_left->inverse() : Eigen::Isometry3d::Identity()),
        table_(ShapeLimitsOf(config, robot), Radians(config.max_gravity_change_deg)),
        graph_(StepLimitsOf(config, robot)),
        stances_(StanceLimitsOf(config, robot)),
        body_height_(robot.body_height_m),
        views_(camera, config.max_resolving_distance_m),
        finder_(staircases),
        tracker_(config.frames_to_change_label),
        map_(EmptyMap(map_id)) {}

  MapChange Label(const PolygonUpdate& update, const PoseEstimate& pose, const Gravity& gravity) {
    ++num_frames_;
    table_.Update(update, gravity, pose.T_world_left.translation());
    const std::vector<RegionShapePtr>& shapes = table_.shapes();
    const Eigen::Isometry3d T_level_left = Eigen::Isometry3d(table_.R_level_world()) * pose.T_world_left;
    eye_ = T_level_left.translation();
    views_.Look(table_, T_level_left, update.t_capture);
    constexpr std::int64_t kCompetePeriod = 5;  // frames
    const bool compete = num_frames_ % kCompetePeriod == 0 || tracker_.contested();
    const Sight sight{camera_, T_level_left, GroundUnder(pose)};
    tracker_.Update(finder_.Find(shapes, tracker_.Models(table_), sight, compete), table_);
    stair_regions_.Update(tracker_);
    graph_.Update(shapes);
    const std::vector<int> seeds = WhereItStands(pose);
    const std::vector<bool> reachable =
        ReachableFrom(seeds, StairLinks(tracker_.looked_at(), table_, robot_), graph_, shapes, config_);
    const std::vector<bool> landings = MayBeLandings(tracker_.looked_at(), shapes);
    const Scene scene{shapes, graph_, reachable, views_.tops(), views_.nearest_view_m(), landings};
    return Publish(update, pose, gravity, LabelRules(config_, stairs_, robot_, scene).Decide());
  }

  const TerrainMapPtr& map() const { return map_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  Explanations Explain(const std::optional<std::int64_t>& only) const {
    const auto wanted = [&only](std::int64_t id) { return !only || id == *only; };
    const ExplanationWords words(config_, stairs_, robot_);
    Explanations explanations;
    for (const auto& [id, record] : records_) {
      if (!record.told() || !wanted(id)) continue;
      explanations.regions.push_back(
          ExplainRegion(record, *table_.ShapeOf(record.polygon()), NeighborsOf(id)));
    }
    for (const auto& region : map_->regions)
      if (region->predicted() && wanted(region->id))
        explanations.regions.push_back(ExplainInferredStep(*region));
    for (const auto& [id, staircase] : tracker_.confirmed())
      if (wanted(id)) explanations.staircases.push_back(ExplainStaircase(staircase));
    for (RegionExplanation& region : explanations.regions) region.text = words.Of(region);
    for (StaircaseExplanation& staircase : explanations.staircases) staircase.text = words.Of(staircase);
    return explanations;
  }

 private:
  /// As far as the region was looked at in the last frame.
  std::vector<NeighborRegion> NeighborsOf(PolygonId id) const {
    std::vector<NeighborRegion> neighbors;
    const int i = table_.IndexOf(id);
    if (i < 0) return neighbors;
    const RegionShape& shape = *table_.shapes()[i];
    for (const auto& [j, link] : graph_.neighbors()[i]) {
      const RegionShape& other = *table_.shapes()[j];
      Eigen::Vector2d beside;  // of the other, near the middle of this one
      other.PlanDistance(shape.centroid.head<2>(), &beside);
      neighbors.push_back(
          {other.id(), link == Link::kJoins, other.HeightAt(beside) - shape.HeightAt(beside)});
    }
    return neighbors;
  }

  /// Height of the ground that the robot stands on when its body is as high as the settings say.
  double GroundUnder(const PoseEstimate& pose) const {
    const Eigen::Vector3d body_world = (pose.T_world_left * T_left_body_).translation();
    return (table_.R_level_world() * body_world).z() - robot_.body_height_m;
  }

  /// The ground from which everything must be reached, and whether it is where the settings say.
  std::vector<int> WhereItStands(const PoseEstimate& pose) {
    const Eigen::Vector3d body_world = (pose.T_world_left * T_left_body_).translation();
    stances_.Stand(body_world, table_.R_level_world());
    const std::vector<int> seeds = stances_.Seeds(table_.shapes(), table_.R_level_world());
    warnings_.clear();
    if (std::optional<std::string> warning =
            body_height_.Look(table_.shapes(), table_.R_level_world() * body_world, stances_.at_feet()))
      warnings_.push_back(std::move(*warning));
    return seeds;
  }

  /// Anew when the region itself has changed; for a change beside it a few frames later will do, and for what
  /// has come into view far below its edges.
  void RefreshEdges(int i, RegionRecord& record) const {
    constexpr std::int64_t kPeriod = 8;
    const RegionShape& shape = *table_.shapes()[i];
    const bool changed = record.OutOfDate(shape.polygon);
    const Eigen::Vector3d reach(kEdgeReach, kEdgeReach, 3.0 * kEdgeReach);
    const bool turn = (num_frames_ + shape.id()) % kPeriod == 0;  // spreads the work over the frames
    if (!changed && !record.edges_stale) record.edges_stale = table_.Touched(shape, reach);
    const bool ground_ahead = shape.lean == Lean::kSupport && views_.nearest_view_m()[i] < kFarthestDrop;
    if (!changed && !(turn && (record.edges_stale || ground_ahead))) return;
    record.new_edges = EdgesOf(i, table_.shapes(), views_.tops(), table_.R_level_world(), eye_);
    if (record.region()) KeepKnownDrops(*record.region(), *shape.polygon, *record.new_edges);
    record.edges_stale = false;
  }

  MapChange Publish(const PolygonUpdate& update, const PoseEstimate& pose, const Gravity& gravity,
                    const std::vector<Verdict>& verdicts) {
    // Where up is a guess, or what the robot stands on, so is every label.
    constexpr double kMaxAssumed = 0.5;
    const bool guess = gravity.source == GravitySource::kAssumed || stances_.disagrees();
    const double cap = guess ? kMaxAssumed : 1.0;
    MapEdits edits;
    TellRegions(verdicts, cap, &edits);
    TellSeen(update, &edits);
    predicted_.Update(tracker_, table_, cap);
    edits.regions.insert(predicted_.changes().begin(), predicted_.changes().end());
    TellStaircases(cap, &edits);

    auto map = std::make_shared<TerrainMap>();
    map->t_capture = update.t_capture;
    map->map_id = map_->map_id;
    map->epoch = pose.epoch;
    map->T_world_left = pose.T_world_left;
    map->covariance = pose.covariance;
    map->gravity = gravity;
    MapChange change{ApplyEdits(edits, *map_, map.get()), map_, map};
    map_ = std::move(map);
    return change;
  }

  /// What is told of the regions that were looked at, and of those that have gone or left a staircase.
  void TellRegions(const std::vector<Verdict>& verdicts, double cap, MapEdits* edits) {
    for (int i = 0; i < static_cast<int>(table_.shapes().size()); ++i) {
      const PolygonId id = table_.shapes()[i]->id();
      TellRegion(i, verdicts[i], stair_regions_.Find(id), cap);
      const RegionRecord& record = records_.at(id);
      edits->regions[id] = record.told() ? record.region() : nullptr;
    }
    for (const PolygonId id : table_.removed()) {
      records_.erase(id);
      edits->regions[id] = nullptr;
    }
    for (const PolygonId id : stair_regions_.left()) {
      const auto left = records_.find(id);
      if (left == records_.end() || !left->second.told() || !left->second.region()->staircase_id) continue;
      left->second.Tell(table_.Find(id), {}, nullptr);
      edits->regions[id] = left->second.region();
    }
  }

  void TellSeen(const PolygonUpdate& update, MapEdits* edits) {
    for (const PolygonId id : update.seen) {
      const auto record = records_.find(id);
      if (record == records_.end() || !record->second.told()) continue;
      record->second.See(update.t_capture);
      edits->regions[id] = record->second.region();
    }
  }

  void TellStaircases(double cap, MapEdits* edits) {
    for (const std::int64_t id : tracker_.removed()) edits->staircases[id] = std::nullopt;
    const auto tell = [&](const TrackedStaircase& s) {
      Staircase told = s.published;
      told.confidence = std::min(told.confidence, cap);
      const std::vector<std::int64_t> predicted = predicted_.IdsOf(s.id);
      told.region_ids.insert(told.region_ids.end(), predicted.begin(), predicted.end());
      edits->staircases[s.id] = std::move(told);
    };
    if (cap != cap_) {
      for (const auto& [id, staircase] : tracker_.confirmed()) tell(staircase);
    } else {
      for (const TrackedStaircase* staircase : tracker_.looked_at()) tell(*staircase);
    }
    cap_ = cap;
  }

  /// Brings the record of one region up to date.
  void TellRegion(int i, Verdict verdict, const InStaircase* step, double cap) {
    const RegionShapePtr& shape = table_.shapes()[i];
    RegionRecord& record = records_[shape->id()];
    if (!step && !StandsOutOfItsNoise(*shape)) {
      record.Withhold();
      return;
    }
    RefreshEdges(i, record);
    if (step) {
      verdict.evidence.by_itself = verdict.label;
      verdict.label = step->place.riser ? TerrainLabel::kStairRiser : TerrainLabel::kStairTread;
      verdict.confidence = step->confidence;
      verdict.evidence.rule = LabelRule::kStep;
    } else {
      verdict = record.Steady(verdict, config_.frames_to_change_label);
    }
    verdict.confidence = std::min(verdict.confidence, cap);
    record.Tell(shape->polygon, verdict, step);
  }

  bool StandsOutOfItsNoise(const RegionShape& shape) const {
    const double edge_m = config_.min_width_in_noise * shape.polygon->noise_m;
    return shape.area_m2 >= edge_m * edge_m;
  }

  LabelingConfig config_;
  StaircaseConfig stairs_;
  RobotConfig robot_;
  StereoCamera camera_;
  Eigen::Isometry3d T_left_body_;
  ShapeTable table_;
  StepGraph graph_;
  StanceMemory stances_;
  BodyHeightCheck body_height_;
  std::vector<std::string> warnings_;
  ViewMemory views_;
  StaircaseFinder finder_;
  StaircaseTracker tracker_;
  StairRegions stair_regions_;
  PredictedRegions predicted_;
  std::map<PolygonId, RegionRecord> records_;
  Eigen::Vector3d eye_ = Eigen::Vector3d::Zero();  ///< where the camera is, level frame
  std::int64_t num_frames_ = 0;
  double cap_ = 1.0;  ///< no label was told to be more certain
  TerrainMapPtr map_;
};

TerrainLabeler::TerrainLabeler(const LabelingConfig& config, const StaircaseConfig& staircases,
                               const RobotConfig& robot, const StereoCamera& camera,
                               const std::optional<Eigen::Isometry3d>& T_body_left, std::int64_t map_id)
    : impl_(std::make_unique<Impl>(config, staircases, robot, camera, T_body_left, map_id)) {}

TerrainLabeler::~TerrainLabeler() = default;

MapChange TerrainLabeler::Label(const PolygonUpdate& update, const PoseEstimate& pose,
                                const Gravity& gravity) {
  return impl_->Label(update, pose, gravity);
}

Explanations TerrainLabeler::Explain(const std::optional<std::int64_t>& only) const {
  return impl_->Explain(only);
}

const std::vector<std::string>& TerrainLabeler::warnings() const { return impl_->warnings(); }

const TerrainMapPtr& TerrainLabeler::map() const { return impl_->map(); }

}  // namespace terrace
