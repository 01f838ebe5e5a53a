// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/terrain_labeler.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/angles.h"
#include "labeling/edge_kinds.h"
#include "labeling/label_rules.h"
#include "labeling/staircase_tracker.h"
#include "labeling/stance.h"
#include "labeling/step_graph.h"
#include "labeling/surface.h"
#include "labeling/view_memory.h"

namespace terrace {
namespace {

SurfaceLimits SurfaceLimitsOf(const LabelingConfig& config, const RobotConfig& robot) {
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

/// The place of one region in a staircase, and how sure it is.
struct InStaircase {
  std::int64_t id = 0;
  StepPlace place;
  double confidence = 0.0;
};

}  // namespace

class TerrainLabeler::Impl {
 public:
  Impl(const LabelingConfig& config, const StaircaseConfig& staircases, const RobotConfig& robot,
       const StereoCamera& camera, const std::optional<Eigen::Isometry3d>& T_body_left, std::int64_t map_id)
      : config_(config),
        robot_(robot),
        T_left_body_(T_body_left ? T_body_left->inverse() : Eigen::Isometry3d::Identity()),
        graph_(StepLimitsOf(config, robot)),
        stances_(StanceLimitsOf(config, robot)),
        views_(camera, config.max_resolving_distance_m),
        finder_(staircases),
        tracker_(config.frames_to_change_label),
        map_(EmptyMap(map_id)) {}

  TerrainMapPtr Label(const PolygonUpdate& update, const PoseEstimate& pose, const Gravity& gravity) {
    ++num_frames_;
    HoldGravity(gravity);
    UpdateSurfaces(update);
    const Eigen::Isometry3d T_level_left = Eigen::Isometry3d(R_level_world_) * pose.T_world_left;
    views_.Look(surfaces_, T_level_left, update.t_capture);
    constexpr std::int64_t kCompetePeriod = 5;  // frames
    const bool compete = num_frames_ % kCompetePeriod == 0;
    tracker_.Update(finder_.Find(surfaces_, tracker_.models(), compete), surfaces_, R_level_world_);
    graph_.Update(surfaces_);
    stances_.Stand((pose.T_world_left * T_left_body_).translation(), R_level_world_);
    const std::vector<bool> reachable = Reachable();
    const Scene scene{surfaces_, graph_, reachable, views_.tops(), views_.nearest_view_m()};
    return Publish(update, pose, gravity, LabelRules(config_, robot_, scene).Decide());
  }

  const TerrainMapPtr& map() const { return map_; }

 private:
  /// What is remembered of one region beside what is published.
  struct Memory {
    std::shared_ptr<const TerrainRegion> region;
    SurfacePtr surface;  ///< that the region was made of
    TerrainLabel next_label = TerrainLabel::kUnknown;
    int num_next = 0;  ///< frames in a row that said next_label instead of the published one
    std::vector<RegionEdge> edges;
    bool edges_stale = true;  ///< something beside the surface has changed since
  };

  void HoldGravity(const Gravity& gravity) {
    const Eigen::Vector3d up = gravity.up_world().normalized();
    const double turned = std::acos(std::clamp(up.dot(R_level_world_.transpose().col(2)), -1.0, 1.0));
    if (surfaces_.empty() || turned > Radians(config_.max_gravity_change_deg)) {
      R_level_world_ = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      by_id_.clear();
    }
  }

  void UpdateSurfaces(const PolygonUpdate& update) {
    std::map<PolygonId, SurfacePtr> by_id;
    surfaces_.clear();
    touched_.clear();
    for (const PolygonPtr& polygon : update.polygons) {
      const auto known = by_id_.find(polygon->id);
      const bool same = known != by_id_.end() && known->second->polygon == polygon;
      SurfacePtr surface =
          same ? known->second : MakeSurface(polygon, R_level_world_, SurfaceLimitsOf(config_, robot_));
      if (!same) {
        touched_.push_back(surface->bounds);
        if (known != by_id_.end()) touched_.push_back(known->second->bounds);
      }
      if (known != by_id_.end()) by_id_.erase(known);
      by_id.emplace(polygon->id, surface);
      surfaces_.push_back(std::move(surface));
    }
    for (const auto& [id, gone] : by_id_) touched_.push_back(gone->bounds);
    by_id_ = std::move(by_id);
  }

  int IndexOf(PolygonId id) const {
    const auto it = std::lower_bound(surfaces_.begin(), surfaces_.end(), id,
                                     [](const SurfacePtr& s, PolygonId wanted) { return s->id() < wanted; });
    return it != surfaces_.end() && (*it)->id() == id ? static_cast<int>(it - surfaces_.begin()) : -1;
  }

  /// Pairs that a staircase joins, although a step between them may not have been seen.
  std::vector<std::pair<int, int>> StairLinks() const {
    constexpr double kSlack = 0.02;
    std::vector<std::pair<int, int>> links;
    for (const TrackedStaircase& s : tracker_.confirmed()) {
      if (s.published.riser_m > robot_.max_step_height_m + kSlack) continue;
      std::vector<std::pair<int, int>> steps;  // step index, surface
      if (const int foot = IndexOf(s.foot_region); foot >= 0) steps.emplace_back(0, foot);
      for (const StepPlace& place : s.places)
        if (!place.riser) steps.emplace_back(place.step_index, IndexOf(place.region));
      if (const int head = IndexOf(s.head_region); head >= 0)
        steps.emplace_back(s.published.num_risers, head);
      std::sort(steps.begin(), steps.end());
      for (std::size_t i = 1; i < steps.size(); ++i) links.emplace_back(steps[i - 1].second, steps[i].second);
    }
    return links;
  }

  std::vector<bool> Reachable() {
    const std::vector<int> seeds = stances_.Seeds(surfaces_, R_level_world_);
    std::vector<std::pair<int, int>> links = StairLinks();
    std::vector<bool> reachable = graph_.Reachable(seeds, links);
    // Ground that goes on behind a strip that was not seen; a chain of such pieces takes as many rounds.
    constexpr int kMaxRounds = 4;
    for (int round = 0; round < kMaxRounds; ++round) {
      const std::vector<std::pair<int, int>> across = LinksAcrossUnseen(reachable);
      if (across.empty()) break;
      links.insert(links.end(), across.begin(), across.end());
      reachable = graph_.Reachable(seeds, links);
    }
    return reachable;
  }

  std::vector<std::pair<int, int>> LinksAcrossUnseen(const std::vector<bool>& reachable) const {
    std::vector<std::pair<int, int>> links;
    for (int i = 0; i < static_cast<int>(surfaces_.size()); ++i) {
      const Surface& lost = *surfaces_[i];
      if (reachable[i] || lost.lean != Lean::kSupport ||
          lost.largest_square_m < 0.5 * config_.min_walkway_edge_m)
        continue;
      for (int j = 0; j < static_cast<int>(surfaces_.size()); ++j) {
        if (!reachable[j] || surfaces_[j]->largest_square_m < 0.5 * config_.min_walkway_edge_m) continue;
        if (!GroundGoesOn(lost, *surfaces_[j], surfaces_, config_)) continue;
        links.emplace_back(i, j);
        break;
      }
    }
    return links;
  }

  bool Touched(const Surface& surface) const {
    const Eigen::Vector3d reach = Eigen::Vector3d(kEdgeReach, kEdgeReach, 3.0 * kEdgeReach);
    const Eigen::AlignedBox3d wide(surface.bounds.min() - reach, surface.bounds.max() + reach);
    return std::any_of(touched_.begin(), touched_.end(),
                       [&](const Eigen::AlignedBox3d& box) { return wide.intersects(box); });
  }

  /// Anew when the region itself has changed; for a change beside it a few frames later will do.
  void RefreshEdges(int i, Memory& memory) const {
    constexpr std::int64_t kPeriod = 8;
    const Surface& surface = *surfaces_[i];
    const bool changed = !memory.surface || memory.surface->polygon != surface.polygon;
    if (!changed && !memory.edges_stale) memory.edges_stale = Touched(surface);
    const bool turn = (num_frames_ + surface.id()) % kPeriod == 0;  // spreads the work over the frames
    if (!changed && !(memory.edges_stale && turn)) return;
    memory.edges = EdgeKindsOf(i, surfaces_, R_level_world_);
    memory.edges_stale = false;
  }

  std::map<PolygonId, InStaircase> StairRegions() const {
    std::map<PolygonId, InStaircase> regions;
    for (const TrackedStaircase& s : tracker_.confirmed())
      for (const StepPlace& place : s.places)
        regions.emplace(place.region, InStaircase{s.id, place, s.published.confidence});
    return regions;
  }

  /// The label to publish: a new one must have been found several times in a row.
  Verdict Steady(Memory& memory, const Verdict& verdict) const {
    if (!memory.region) return verdict;
    const TerrainLabel told = memory.region->label;
    if (verdict.label == told) {
      memory.num_next = 0;
      return verdict;
    }
    if (verdict.label != memory.next_label) memory.num_next = 0;
    memory.next_label = verdict.label;
    ++memory.num_next;
    // A staircase has been confirmed by its tracker, and its regions must agree with it at once.
    const bool step_before = memory.region->staircase_id.has_value();
    if (told == TerrainLabel::kUnknown || step_before || memory.num_next >= config_.frames_to_change_label) {
      memory.num_next = 0;
      return verdict;
    }
    return {told, memory.region->confidence};
  }

  std::shared_ptr<const TerrainRegion> MakeRegion(const Surface& surface, const Memory& memory,
                                                  const Verdict& verdict, const InStaircase* stairs) const {
    // A confidence that moves by less is not worth a message.
    constexpr double kConfidenceStep = 0.05;
    const Polygon& polygon = *surface.polygon;
    const std::shared_ptr<const TerrainRegion>& old = memory.region;
    const bool same_polygon = old && memory.surface && memory.surface->polygon == surface.polygon;
    const std::optional<std::int64_t> staircase_id = stairs ? std::optional(stairs->id) : std::nullopt;
    const std::optional<int> step_index = stairs ? std::optional(stairs->place.step_index) : std::nullopt;
    if (same_polygon && old->label == verdict.label && old->staircase_id == staircase_id &&
        old->step_index == step_index && old->edges == memory.edges &&
        std::abs(old->confidence - verdict.confidence) < kConfidenceStep)
      return old;
    auto region = std::make_shared<TerrainRegion>();
    region->id = polygon.id;
    region->revision = old ? old->revision + 1 : 1;
    region->label = verdict.label;
    region->confidence = verdict.confidence;
    region->plane_world = polygon.plane_world;
    region->plane_covariance = polygon.plane_covariance;
    region->centroid_world = polygon.centroid_world;
    region->rms_m = polygon.rms_m;
    region->area_m2 = polygon.area_m2;
    region->outline_world = polygon.outline_world;
    region->holes_world = polygon.holes_world;
    region->edges = memory.edges;
    region->support = polygon.support;
    region->num_observations = polygon.num_observations;
    region->first_seen = polygon.first_seen;
    region->last_seen = polygon.last_seen;
    region->staircase_id = staircase_id;
    region->step_index = step_index;
    return region;
  }

  TerrainMapPtr Publish(const PolygonUpdate& update, const PoseEstimate& pose, const Gravity& gravity,
                        const std::vector<Verdict>& verdicts) {
    constexpr double kMaxAssumed = 0.5;  // up is a guess, and so is every label
    const double cap = gravity.source == GravitySource::kAssumed ? kMaxAssumed : 1.0;
    auto map = std::make_shared<TerrainMap>();
    map->t_capture = update.t_capture;
    map->map_id = map_->map_id;
    map->epoch = pose.epoch;
    map->T_world_left = pose.T_world_left;
    map->covariance = pose.covariance;
    map->gravity = gravity;
    const std::map<PolygonId, InStaircase> stairs = StairRegions();
    std::map<PolygonId, Memory> memories;
    for (int i = 0; i < static_cast<int>(surfaces_.size()); ++i) {
      const Surface& surface = *surfaces_[i];
      const auto known = memories_.find(surface.id());
      Memory& memory = memories[surface.id()];
      if (known != memories_.end()) memory = std::move(known->second);
      const auto step = stairs.find(surface.id());
      if (step == stairs.end() && !StandsOutOfItsNoise(surface)) continue;
      RefreshEdges(i, memory);
      Verdict verdict = verdicts[i];
      if (step != stairs.end()) {
        verdict.label = step->second.place.riser ? TerrainLabel::kStairRiser : TerrainLabel::kStairTread;
        verdict.confidence = step->second.confidence;
      } else {
        verdict = Steady(memory, verdict);
      }
      verdict.confidence = std::min(verdict.confidence, cap);
      memory.region = MakeRegion(surface, memory, verdict, step != stairs.end() ? &step->second : nullptr);
      memory.surface = surfaces_[i];
      map->regions.push_back(memory.region);
    }
    memories_ = std::move(memories);
    for (const TrackedStaircase& s : tracker_.confirmed()) {
      map->staircases.push_back(s.published);
      map->staircases.back().confidence = std::min(s.published.confidence, cap);
    }
    map->seq = map_->seq + (Differs(*map, *map_) ? 1 : 0);
    map_ = map;
    return map_;
  }

  bool StandsOutOfItsNoise(const Surface& surface) const {
    const double edge_m = config_.min_width_in_noise * surface.polygon->noise_m;
    return surface.area_m2 >= edge_m * edge_m;
  }

  static bool Differs(const TerrainMap& a, const TerrainMap& b) {
    const auto same_staircase = [](const Staircase& s, const Staircase& t) {
      return s.id == t.id && s.num_risers == t.num_risers && s.num_treads == t.num_treads &&
             s.riser_m == t.riser_m && s.tread_m == t.tread_m && s.width_m == t.width_m &&
             s.base_world() == t.base_world() && s.confidence == t.confidence &&
             s.region_ids == t.region_ids && s.last_seen == t.last_seen;
    };
    return a.regions != b.regions || !std::equal(a.staircases.begin(), a.staircases.end(),
                                                 b.staircases.begin(), b.staircases.end(), same_staircase);
  }

  LabelingConfig config_;
  RobotConfig robot_;
  Eigen::Isometry3d T_left_body_;
  Eigen::Matrix3d R_level_world_ = Eigen::Matrix3d::Identity();
  std::map<PolygonId, SurfacePtr> by_id_;
  std::vector<SurfacePtr> surfaces_;          ///< ascending by id
  std::vector<Eigen::AlignedBox3d> touched_;  ///< where this frame changed something; level frame
  StepGraph graph_;
  StanceMemory stances_;
  ViewMemory views_;
  StaircaseFinder finder_;
  StaircaseTracker tracker_;
  std::map<PolygonId, Memory> memories_;
  std::int64_t num_frames_ = 0;
  TerrainMapPtr map_;
};

std::vector<std::string> RobotConfig::Problems() const {
  std::vector<std::string> problems;
  const auto need = [&](bool holds, const char* rule) {
    if (!holds) problems.emplace_back(rule);
  };
  need(body_height_m > 0.0, "body_height_m must be positive");
  need(max_step_height_m > 0.0, "max_step_height_m must be positive");
  need(max_step_reach_m > 0.0, "max_step_reach_m must be positive");
  need(foot_radius_m >= 0.0, "foot_radius_m must not be negative");
  need(max_walkway_slope_deg > 0.0, "max_walkway_slope_deg must be positive");
  need(max_ramp_slope_deg >= max_walkway_slope_deg && max_ramp_slope_deg < 60.0,
       "max_ramp_slope_deg must lie between max_walkway_slope_deg and 60");
  return problems;
}

std::vector<std::string> LabelingConfig::Problems() const {
  std::vector<std::string> problems;
  const auto need = [&](bool holds, const char* rule) {
    if (!holds) problems.emplace_back(rule);
  };
  need(min_walkway_edge_m > 0.0, "min_walkway_edge_m must be positive");
  need(min_wall_height_m > 0.0, "min_wall_height_m must be positive");
  need(min_upright_deg >= 60.0 && min_upright_deg < 90.0, "min_upright_deg must lie between 60 and 90");
  need(max_joint_gap_m >= 0.0, "max_joint_gap_m must not be negative");
  need(max_joint_height_m > 0.0, "max_joint_height_m must be positive");
  need(max_unseen_gap_m >= 0.0, "max_unseen_gap_m must not be negative");
  need(min_ramp_rise_m >= 0.0, "min_ramp_rise_m must not be negative");
  need(max_resolving_distance_m > 0.0, "max_resolving_distance_m must be positive");
  need(ground_search_m > 0.0, "ground_search_m must be positive");
  need(max_stance_distance_m > 0.0, "max_stance_distance_m must be positive");
  need(min_decided_area_m2 >= 0.0, "min_decided_area_m2 must not be negative");
  need(min_width_in_noise >= 0.0, "min_width_in_noise must not be negative");
  need(frames_to_change_label >= 1, "frames_to_change_label must be at least 1");
  need(max_gravity_change_deg >= 0.0, "max_gravity_change_deg must not be negative");
  return problems;
}

TerrainLabeler::TerrainLabeler(const LabelingConfig& config, const StaircaseConfig& staircases,
                               const RobotConfig& robot, const StereoCamera& camera,
                               const std::optional<Eigen::Isometry3d>& T_body_left, std::int64_t map_id)
    : impl_(std::make_unique<Impl>(config, staircases, robot, camera, T_body_left, map_id)) {}

TerrainLabeler::~TerrainLabeler() = default;

TerrainMapPtr TerrainLabeler::Label(const PolygonUpdate& update, const PoseEstimate& pose,
                                    const Gravity& gravity) {
  return impl_->Label(update, pose, gravity);
}

const TerrainMapPtr& TerrainLabeler::map() const { return impl_->map(); }

}  // namespace terrace
