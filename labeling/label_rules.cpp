// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/label_rules.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/angles.h"
#include "labeling/slope_evidence.h"

namespace terrace {
namespace {

/// Chance that a normally distributed value lies above zero.
double ChancePositive(double mean, double sigma) {
  return 0.5 * std::erfc(-mean / (std::sqrt(2.0) * std::max(sigma, 1e-6)));
}

/// Evidence from few looks is worth less.
double Seasoned(double confidence, const RegionShape& shape) {
  constexpr double kLooks = 3.0;
  return confidence * (1.0 - 0.4 * std::exp(-shape.polygon->num_observations / kLooks));
}

}  // namespace

bool GroundGoesOn(const RegionShape& a, const RegionShape& b, const std::vector<RegionShapePtr>& shapes,
                  const LabelingConfig& config) {
  const Eigen::Vector3d reach(config.max_unseen_gap_m, config.max_unseen_gap_m, config.max_joint_height_m);
  if (!Eigen::AlignedBox3d(a.bounds.min() - reach, a.bounds.max() + reach).intersects(b.bounds)) return false;
  for (const Eigen::Vector2d& p : a.plan.front()) {
    const double z = a.HeightAt(p);
    if (std::abs(z - b.HeightAt(p)) > 4.0 * config.max_joint_height_m) continue;  // quicker than the outline
    Eigen::Vector2d q;
    if (b.PlanDistance(p, &q) > config.max_unseen_gap_m) continue;
    if (std::abs(z - b.HeightAt(q)) > 2.0 * config.max_joint_height_m) continue;
    const Eigen::Vector2d middle = 0.5 * (p + q);
    const bool lower_between = std::any_of(shapes.begin(), shapes.end(), [&](const RegionShapePtr& s) {
      if (s.get() == &a || s.get() == &b || s->lean != Lean::kSupport) return false;
      return s->HeightAt(middle) < z - config.max_joint_height_m &&
             s->PlanDistance(middle) < config.max_joint_gap_m;
    });
    if (!lower_between) return true;
  }
  return false;
}

LabelRules::LabelRules(const LabelingConfig& config, const StaircaseConfig& stairs, const RobotConfig& robot,
                       const Scene& scene)
    : config_(config),
      stairs_(stairs),
      robot_(robot),
      scene_(scene),
      index_(scene.shapes, config.ground_search_m) {}

bool LabelRules::Level(const RegionShape& shape) const {
  if (shape.lean != Lean::kSupport) return false;
  if (shape.slope_rad <= Radians(robot_.max_walkway_slope_deg)) return true;
  // A small piece that leans by a few centimetres is noise or uneven ground.
  return shape.heights().length() < config_.min_ramp_rise_m;
}

std::vector<bool> LabelRules::PartOfLargeGround() const {
  // Level pieces that join are one ground, and so are sloped ones; large when one of its pieces is, or when
  // together they are wide enough both ways.
  const int n = static_cast<int>(scene_.shapes.size());
  const double edge = config_.min_walkway_edge_m;
  // The raster of LargestSquare has cells of a tenth; a box too narrow by less than that is told by its
  // sides.
  const double large_square = 0.9 * edge;
  constexpr double kOutline = 0.01;  // how well outlines are known
  std::vector<bool> large(n, false);
  std::vector<bool> done(n, false);
  for (int start = 0; start < n; ++start) {
    if (done[start] || scene_.shapes[start]->lean != Lean::kSupport) continue;
    const bool level = Level(*scene_.shapes[start]);
    std::vector<int> pieces{start};
    done[start] = true;
    bool any_large = false;
    double area = 0.0;
    PlanRing corners;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const RegionShape& s = *scene_.shapes[pieces[k]];
      any_large |= s.largest_square_m >= large_square && s.rectangle.depth_m >= edge - kOutline;
      area += s.area_m2;
      corners.insert(corners.end(), s.plan.front().begin(), s.plan.front().end());
      for (const auto& [j, link] : scene_.graph.neighbors()[pieces[k]]) {
        if (link != Link::kJoins || done[j] || Level(*scene_.shapes[j]) != level) continue;
        done[j] = true;
        pieces.push_back(j);
      }
    }
    if (!any_large && pieces.size() > 1 && area >= edge * edge) {
      const Interval x = Extent(corners, scene_.shapes[start]->rectangle.long_axis);
      const Interval y = Extent(corners, scene_.shapes[start]->rectangle.short_axis());
      // Pieces with gaps between them must make up most of what they span.
      any_large = std::min(x.length(), y.length()) >= edge && area >= 0.7 * x.length() * y.length();
    }
    for (const int i : pieces) large[i] = any_large;
  }
  return large;
}

std::optional<double> LabelRules::GroundHeight(const Eigen::Vector2d& p, double max_z, int except) const {
  double nearest = config_.ground_search_m;
  std::optional<double> height;
  for (const int j : index_.Near(p)) {
    const RegionShape& s = *scene_.shapes[j];
    if (j == except || s.lean != Lean::kSupport || s.bounds.min().z() > max_z) continue;
    const Eigen::Vector2d outside = (s.bounds.min().head<2>() - p).cwiseMax(p - s.bounds.max().head<2>());
    if (outside.maxCoeff() > nearest) continue;
    Eigen::Vector2d q;
    const double distance = s.PlanDistance(p, &q);
    const double z = s.HeightAt(q);
    // Of two pieces that lie above each other the face stands on the upper one.
    if (z > max_z || distance > nearest || (height && distance == nearest && z <= *height)) continue;
    nearest = distance;
    height = z;
  }
  return height;
}

LabelRules::Face LabelRules::MeasureFace(int i) const {
  const RegionShape& face = *scene_.shapes[i];
  constexpr int kMaxSamples = 12;
  constexpr double kFootTolerance = 0.1;  // how far the seen foot may lie below the ground
  constexpr double kBeforeFace = 0.05;    // the ground is looked for on the side that was seen
  constexpr double kTopTolerance = 0.08;  // rounded edges
  const int n = static_cast<int>(face.columns.size());
  const int stride = std::max(1, (n + kMaxSamples - 1) / kMaxSamples);
  std::vector<double> heights;
  int tops = 0, high_samples = 0, samples = 0;
  Face measured;
  for (int c = stride / 2; c < n; c += stride) {
    const FaceColumn& column = face.columns[c];
    const Eigen::Vector2d foot =
        face.FacePoint(column.along_m, column.bottom_m).head<2>() + kBeforeFace * face.front();
    const std::optional<double> ground = GroundHeight(foot, column.bottom_m + kFootTolerance, i);
    measured.ground_known |= ground.has_value();
    heights.push_back(column.top_m - ground.value_or(column.bottom_m));
    ++samples;
    // What is as high as a riser in the same plane, and bears a tread, is no top of the wall beside it.
    if (!face.ReachesUpperHalf(column)) continue;
    ++high_samples;
    const Eigen::Vector2d behind =
        face.FacePoint(column.along_m, column.top_m).head<2>() - kTopTolerance * face.front();
    for (const int j : index_.Near(behind)) {
      const RegionShape& s = *scene_.shapes[j];
      if (s.lean != Lean::kSupport || s.bounds.max().z() < column.top_m - kTopTolerance ||
          s.bounds.min().z() > column.top_m + kTopTolerance)
        continue;
      Eigen::Vector2d q;
      if (s.PlanDistance(behind, &q) > kTopTolerance ||
          std::abs(s.HeightAt(q) - column.top_m) > kTopTolerance)
        continue;
      ++tops;
      break;
    }
  }
  if (samples == 0) return measured;
  // So much of the width must reach this high: a spike is no wall, but a wall may have a low middle, where it
  // is the face of a step as well.
  constexpr double kMinWidth = 0.2;
  constexpr double kMinSpacing = 0.01;
  const double spacing = std::max(kMinSpacing, Extent(face.plan.front(), face.face_axis).length() / samples);
  const int num_high =
      std::clamp(static_cast<int>(std::ceil(kMinWidth / spacing)), 1, std::max(1, samples / 5));
  const auto high = heights.end() - num_high;
  std::nth_element(heights.begin(), high, heights.end());
  measured.height_m = *high;
  measured.has_top = high_samples > 0 && 2 * tops >= high_samples;
  return measured;
}

Verdict LabelRules::DecideFace(int i) const {
  const RegionShape& face = *scene_.shapes[i];
  if (face.area_m2 < config_.min_decided_area_m2 || face.columns.empty())
    return {TerrainLabel::kUnknown, 0.3, LabelRule::kTooSmall};
  const Face measured = MeasureFace(i);
  Verdict verdict = DecideMeasuredFace(i, measured);
  verdict.evidence.height_m = measured.height_m;
  return verdict;
}

Verdict LabelRules::DecideMeasuredFace(int i, const Face& measured) const {
  const RegionShape& face = *scene_.shapes[i];
  const double upright = ChancePositive(
      std::min(face.slope_rad, std::numbers::pi - face.slope_rad) - Radians(config_.min_upright_deg),
      face.slope_sigma_rad);
  const double doubt = measured.ground_known ? 1.0 : 0.8;
  if (measured.height_m >= config_.min_wall_height_m)
    return {TerrainLabel::kWall, Seasoned(0.95 * upright * doubt, face), LabelRule::kHighFace};
  if (measured.has_top)
    return {TerrainLabel::kObstacle, Seasoned(0.9 * upright * doubt, face), LabelRule::kFaceWithTop};
  switch (scene_.tops[i]) {
    case TopView::kOutOfView:
      return {TerrainLabel::kWall, Seasoned(0.75 * upright * doubt, face), LabelRule::kFaceOutOfView};
    case TopView::kSeen:
      return {TerrainLabel::kObstacle, Seasoned(0.75 * upright * doubt, face), LabelRule::kFaceEnds};
    case TopView::kNotJudged:
      break;
  }
  return {TerrainLabel::kUnknown, 0.3, LabelRule::kTopNotSeen};
}

int LabelRules::WallContinuedBy(int i, const std::vector<Verdict>& verdicts) const {
  // Matching leaves holes in plain walls: what lies in the plane of a wall and near it is part of it, unless
  // something lies on top.
  const RegionShape& face = *scene_.shapes[i];
  constexpr double kSameNormal = 0.985;  // 10 deg
  constexpr double kSamePlane = 0.10;    // far walls come in several layers
  const double max_gap = config_.ground_search_m;
  const Interval width = Extent(face.plan.front(), face.face_axis);
  for (int j = 0; j < static_cast<int>(scene_.shapes.size()); ++j) {
    const RegionShape& wall = *scene_.shapes[j];
    if (verdicts[j].label != TerrainLabel::kWall || wall.area_m2 < face.area_m2) continue;
    if (face.plane.normal.dot(wall.plane.normal) < kSameNormal) continue;
    if (std::abs(wall.plane.SignedDistance(face.centroid)) > kSamePlane) continue;
    if (width.Overlap(Extent(wall.plan.front(), face.face_axis)) < -max_gap) continue;
    if (face.heights().Overlap(wall.heights()) >= -max_gap) return j;
  }
  return -1;
}

/// An incline in which steps may hide, or that is no plane, is never told for sure.
std::optional<Verdict> LabelRules::Undecided(const RegionShape& slope) const {
  if (!CouldBeStairs(slope, stairs_)) return std::nullopt;
  switch (JudgeSlope(slope, stairs_)) {
    case SlopeEvidence::kPlane:
      return std::nullopt;
    case SlopeEvidence::kNotResolved:
      return Verdict{TerrainLabel::kUnknown, 0.4, LabelRule::kSlopeNotResolved};
    case SlopeEvidence::kNotPlane:
      return Verdict{TerrainLabel::kUnknown, 0.4, LabelRule::kSlopeNotPlane};
  }
  return std::nullopt;
}

/// Ground is offered where it is known how it leans, and that it leans no more than a walkway.
std::optional<Verdict> LabelRules::LeansTooMuch(const RegionShape& level) const {
  const double most_rad = Radians(robot_.max_walkway_slope_deg);
  const double doubt_rad = 2.0 * level.slope_sigma_rad;
  if (doubt_rad > most_rad) return Verdict{TerrainLabel::kUnknown, 0.4, LabelRule::kSlopeNotKnown};
  if (level.slope_rad - doubt_rad > most_rad)
    return Verdict{TerrainLabel::kUnknown, 0.4, LabelRule::kSlopeTooSmall};
  return std::nullopt;
}

Verdict LabelRules::DecideSteep(int i) const {
  const RegionShape& s = *scene_.shapes[i];
  if (s.area_m2 < 2.0 * config_.min_decided_area_m2)
    return {TerrainLabel::kUnknown, 0.3, LabelRule::kTooSmall};
  if (const std::optional<Verdict> undecided = Undecided(s)) return *undecided;
  constexpr double kFootTolerance = 0.1;
  const auto ground =
      GroundHeight(s.centroid.head<2>() + 0.5 * s.rectangle.depth_m * s.plane.normal.head<2>().normalized(),
                   s.bounds.min().z() + kFootTolerance, i);
  if (!ground || s.bounds.min().z() - *ground > config_.ground_search_m ||
      scene_.nearest_view_m[i] > config_.max_resolving_distance_m)
    return {TerrainLabel::kUnknown, 0.3, LabelRule::kSteepFootNotKnown};
  return {TerrainLabel::kObstacle, Seasoned(0.6, s), LabelRule::kSteepOnGround};
}

std::optional<double> LabelRules::HeightOverSurroundings(int i) const {
  const RegionShape& s = *scene_.shapes[i];
  const double low_enough = config_.max_joint_height_m;
  // Reflections and noise make up scraps below any large floor: the top of a large thing has lower ground
  // along a good part of its outline.
  const double least_share = s.largest_square_m >= 0.9 * config_.min_walkway_edge_m ? 0.2 : 0.0;
  std::optional<double> height;
  double around_m = 0.0, lower_m = 0.0;
  const PlanRing& ring = s.plan.front();
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Eigen::Vector2d& p = ring[k];
    const Eigen::Vector2d& before = ring[(k + ring.size() - 1) % ring.size()];
    const Eigen::Vector2d& after = ring[(k + 1) % ring.size()];
    const double beside_m = 0.5 * ((after - p).norm() + (p - before).norm());
    around_m += beside_m;
    const double z = s.HeightAt(p);
    const auto ground = GroundHeight(p, z - low_enough, i);
    if (!ground) continue;
    lower_m += beside_m;
    if (!height || z - *ground < *height) height = z - *ground;
  }
  return lower_m >= least_share * around_m ? height : std::nullopt;
}

Verdict LabelRules::DecideLevel(int i, const std::vector<bool>& large) const {
  const RegionShape& s = *scene_.shapes[i];
  const double level = ChancePositive(Radians(robot_.max_ramp_slope_deg) - s.slope_rad, s.slope_sigma_rad);
  if (const std::optional<Verdict> undecided = Undecided(s)) return *undecided;
  const std::optional<Verdict> leans = LeansTooMuch(s);
  if (large[i] && scene_.reachable[i])
    return leans.value_or(
        Verdict(TerrainLabel::kWalkway, Seasoned(0.97 * level, s), LabelRule::kReachableGround));
  if (s.area_m2 < config_.min_decided_area_m2) return {TerrainLabel::kUnknown, 0.3, LabelRule::kTooSmall};
  const std::optional<double> height = HeightOverSurroundings(i);
  Verdict verdict(TerrainLabel::kUnknown, 0.4, LabelRule::kTooSmallToWalkOn);
  // The top of something that stands on the ground; higher up it is a shelf or a ledge. Climbing, the robot
  // sees little of a landing at first.
  if (scene_.landings[i]) {
    // Nothing more is known of it yet.
  } else if (height && *height < config_.min_wall_height_m) {
    verdict = {TerrainLabel::kObstacle, Seasoned(0.85 * level, s), LabelRule::kStandsOnGround};
  } else if (const int ground = height ? -1 : GroundContinuedBy(i, large); ground >= 0) {
    verdict = leans.value_or(
        Verdict(TerrainLabel::kWalkway, Seasoned(0.7 * level, s), LabelRule::kContinuesGround));
    verdict.evidence.decided_by = scene_.shapes[ground]->id();
  } else if (!scene_.reachable[i]) {
    verdict = {TerrainLabel::kLevel, Seasoned(0.6 * level, s), LabelRule::kOutOfReach};
  }
  verdict.evidence.height_m = height;
  return verdict;
}

/// A scrap of the floor, cut off by something that hides the rest.
int LabelRules::GroundContinuedBy(int i, const std::vector<bool>& large) const {
  for (int j = 0; j < static_cast<int>(scene_.shapes.size()); ++j) {
    if (!large[j] || !scene_.reachable[j] || !Level(*scene_.shapes[j])) continue;
    if (GroundGoesOn(*scene_.shapes[i], *scene_.shapes[j], scene_.shapes, config_)) return j;
  }
  return -1;
}

Verdict LabelRules::DecideSlope(int i, bool large) const {
  const RegionShape& s = *scene_.shapes[i];
  const double walkable = ChancePositive(Radians(robot_.max_ramp_slope_deg) - s.slope_rad, s.slope_sigma_rad);
  const double sloped =
      ChancePositive(s.slope_rad - Radians(robot_.max_walkway_slope_deg), s.slope_sigma_rad);
  if (const std::optional<Verdict> undecided = Undecided(s)) return *undecided;
  if (large && scene_.reachable[i])
    return {TerrainLabel::kRamp, Seasoned(0.95 * walkable * sloped, s), LabelRule::kReachableSlope};
  if (large) return {TerrainLabel::kUnknown, 0.3, LabelRule::kSlopeOutOfReach};
  if (s.area_m2 < config_.min_decided_area_m2) return {TerrainLabel::kUnknown, 0.3, LabelRule::kTooSmall};
  const std::optional<double> height = HeightOverSurroundings(i);
  Verdict verdict(TerrainLabel::kUnknown, 0.3, LabelRule::kSlopeTooSmall);
  if (height) verdict = {TerrainLabel::kObstacle, Seasoned(0.6, s), LabelRule::kStandsOnGround};
  verdict.evidence.height_m = height;
  return verdict;
}

std::vector<Verdict> LabelRules::Decide() const {
  const int n = static_cast<int>(scene_.shapes.size());
  const std::vector<bool> large = PartOfLargeGround();
  std::vector<Verdict> verdicts(n);
  for (int i = 0; i < n; ++i) {
    const RegionShape& s = *scene_.shapes[i];
    switch (s.lean) {
      case Lean::kSupport:
        verdicts[i] = Level(s) ? DecideLevel(i, large) : DecideSlope(i, large[i]);
        break;
      case Lean::kSteep:
        verdicts[i] = DecideSteep(i);
        break;
      case Lean::kUpright:
        verdicts[i] = DecideFace(i);
        break;
      case Lean::kFacingDown:
        verdicts[i] = {TerrainLabel::kUnknown, 0.5, LabelRule::kFacesDown};
        break;
    }
  }
  const std::vector<Verdict> first = verdicts;
  for (int i = 0; i < n; ++i) {
    if (scene_.shapes[i]->lean != Lean::kUpright || first[i].label == TerrainLabel::kWall) continue;
    if (first[i].evidence.rule == LabelRule::kFaceWithTop) continue;
    const int wall = WallContinuedBy(i, first);
    if (wall < 0) continue;
    verdicts[i].label = TerrainLabel::kWall;
    verdicts[i].confidence = Seasoned(0.7, *scene_.shapes[i]);
    verdicts[i].evidence.rule = LabelRule::kContinuesWall;
    verdicts[i].evidence.decided_by = scene_.shapes[wall]->id();
  }
  for (int i = 0; i < n; ++i) {
    verdicts[i].evidence.large = large[i];
    verdicts[i].evidence.reachable = scene_.reachable[i];
    verdicts[i].evidence.nearest_view_m = scene_.nearest_view_m[i];
  }
  return verdicts;
}

}  // namespace terrace
