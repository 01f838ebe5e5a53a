// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/explanation.h"
#include "core/terrain_map.h"
#include "labeling/labeling_config.h"
#include "labeling/plan_index.h"
#include "labeling/region_shape.h"
#include "labeling/staircase_config.h"
#include "labeling/step_graph.h"

namespace terrace {

/// Whether a face ends where it seems to end.
enum class TopView {
  kNotJudged,  ///< never near enough
  kSeen,       ///< what lies above it was in view, and is not part of it
  kOutOfView,  ///< it ends where the view ended
};

/// What the rules know about the shapes of one map; all vectors run in parallel.
struct Scene {
  const std::vector<RegionShapePtr>& shapes;
  const StepGraph& graph;
  const std::vector<bool>& reachable;
  const std::vector<TopView>& tops;
  const std::vector<double>& nearest_view_m;  ///< least distance from which each was seen
  const std::vector<bool>& landings;          ///< whether each may be what a told staircase leads to
};

/// What a label was decided by.
struct LabelEvidence {
  LabelRule rule = LabelRule::kNotLookedAt;
  /// Of a face: its top over the ground at its foot. Of a support: over the lower ground beside it.
  std::optional<double> height_m;
  PolygonId decided_by = 0;  ///< the wall or the ground that it continues; 0: none
  bool large = false;        ///< of a support: alone or with what joins it
  bool reachable = false;    ///< likewise
  double nearest_view_m = 0.0;
  std::optional<TerrainLabel> by_itself;  ///< of a step: what the rules make of it without its staircase
};

struct Verdict {
  Verdict() = default;
  Verdict(TerrainLabel l, double c, LabelRule rule) : label(l), confidence(c) { evidence.rule = rule; }

  TerrainLabel label = TerrainLabel::kUnknown;
  double confidence = 0.0;
  LabelEvidence evidence;
};

/// True when two supports are at one height across a gap, and what lies between them was not seen to be
/// lower.
bool GroundGoesOn(const RegionShape& a, const RegionShape& b, const std::vector<RegionShapePtr>& shapes,
                  const LabelingConfig& config);

/// The meaning of the labels in DESIGN.md as rules, for everything but staircases.
class LabelRules {
 public:
  LabelRules(const LabelingConfig& config, const StaircaseConfig& stairs, const RobotConfig& robot,
             const Scene& scene);

  std::vector<Verdict> Decide() const;

 private:
  struct Face {
    double height_m = 0.0;  ///< of its top above the ground at its foot, where it is highest
    bool ground_known = false;
    bool has_top = false;  ///< a level piece begins at its upper edge
  };
  bool Level(const RegionShape& shape) const;
  std::vector<bool> PartOfLargeGround() const;
  std::optional<double> GroundHeight(const Eigen::Vector2d& p, double max_z, int except) const;
  Face MeasureFace(int i) const;
  std::optional<double> HeightOverSurroundings(int i) const;
  /// The wall; -1: it continues none.
  int WallContinuedBy(int i, const std::vector<Verdict>& verdicts) const;
  /// The ground; -1: there is none.
  int GroundContinuedBy(int i, const std::vector<bool>& large) const;
  Verdict DecideFace(int i) const;
  Verdict DecideMeasuredFace(int i, const Face& measured) const;
  Verdict DecideSteep(int i) const;
  Verdict DecideLevel(int i, const std::vector<bool>& large) const;
  Verdict DecideSlope(int i, bool large) const;
  std::optional<Verdict> Undecided(const RegionShape& slope) const;
  std::optional<Verdict> LeansTooMuch(const RegionShape& level) const;

  const LabelingConfig& config_;
  const StaircaseConfig& stairs_;
  const RobotConfig& robot_;
  const Scene& scene_;
  PlanIndex index_;
};

}  // namespace terrace
