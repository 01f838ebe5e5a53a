// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/inferred_steps.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "labeling/free_rectangle.h"

namespace terrace {
namespace {

/// What is farther above a step is a ceiling, not a thing that lies on it.
constexpr double kHeadroom = 1.2;
/// Cells in which a tread is looked at.
constexpr double kCellDepth = 0.03;
constexpr double kCellWidth = 0.10;
/// Smaller pieces carry no foot.
constexpr double kMinDepth = 0.06;
constexpr double kMinWidth = 0.30;
/// What is known worse is not told.
constexpr double kMaxHeightSigma = 0.025;
constexpr double kMaxPlaceSigma = 0.06;

/// True when something was seen here that is this step itself, or excludes it.
bool Taken(const RegionShape& shape, const Eigen::Vector2d& p, double z) {
  constexpr double kBeside = 0.02;
  const Eigen::Vector2d outside =
      (shape.bounds.min().head<2>() - p).cwiseMax(p - shape.bounds.max().head<2>());
  if (outside.maxCoeff() > kBeside || shape.bounds.min().z() > z + kHeadroom) return false;
  if (shape.lean == Lean::kUpright) {
    // The riser above ends at the next tread; what is much higher than a step cuts the flight off.
    constexpr double kHigherThanStep = 0.35;
    if (shape.bounds.min().z() > z + kHeadroom || shape.bounds.max().z() < z + kHigherThanStep) return false;
    const Eigen::Vector3d on_face = shape.FacePoint(shape.face_axis.dot(p), z);
    return (on_face.head<2>() - p).norm() <= kBeside;
  }
  return shape.lean == Lean::kSupport && shape.HeightAt(p) < z + kHeadroom && shape.PlanDistance(p) <= 0.0;
}

/// The part of tread k of which nothing was seen.
std::optional<FreeRectangle> UnseenPart(const FlightModel& model, int k, double run_m,
                                        const std::vector<const RegionShape*>& shapes) {
  const double z = model.foot_z + k * model.rise_m;
  const int rows = std::max(1, static_cast<int>(std::lround(run_m / kCellDepth)));
  const int columns = std::max(1, static_cast<int>(std::lround(model.lateral.length() / kCellWidth)));
  std::vector<bool> free(static_cast<std::size_t>(rows) * columns, true);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double lateral = model.lateral.low + (column + 0.5) / columns * model.lateral.length();
      const Eigen::Vector2d p = model.EdgePoint(k + (row + 0.5) / rows, lateral);
      free[row * columns + column] = std::none_of(
          shapes.begin(), shapes.end(), [&](const RegionShape* shape) { return Taken(*shape, p, z); });
    }
  }
  const FreeRectangle cells = LargestFreeRectangle(free, rows, columns);
  FreeRectangle part{cells.row_begin / rows, cells.row_end / rows, cells.column_begin / columns,
                     cells.column_end / columns};
  const bool large_enough = (part.row_end - part.row_begin) * run_m >= kMinDepth &&
                            (part.column_end - part.column_begin) * model.lateral.length() >= kMinWidth;
  return large_enough ? std::optional(part) : std::nullopt;
}

Ring Level(const FlightModel& model, int k, const FreeRectangle& part) {
  const double z = model.foot_z + k * model.rise_m;
  const auto at = [&](double row, double column) {
    const Eigen::Vector2d p = model.EdgePoint(k + row, model.lateral.low + column * model.lateral.length());
    return Eigen::Vector3d(p.x(), p.y(), z);
  };
  Ring ring{at(part.row_begin, part.column_begin), at(part.row_end, part.column_begin),
            at(part.row_end, part.column_end), at(part.row_begin, part.column_end)};
  if (SignedArea(ring, Eigen::Vector3d::UnitZ()) < 0.0) std::reverse(ring.begin(), ring.end());
  return ring;
}

InferredStep Riser(const FlightModel& model, int k) {
  const Eigen::Vector2d up = model.UpAt(k), a = model.EdgePoint(k, model.lateral.low),
                        b = model.EdgePoint(k, model.lateral.high);
  const double low = model.foot_z + (k - 1) * model.rise_m, high = low + model.rise_m;
  InferredStep step;
  step.riser = true;
  step.step_index = k;
  step.plane.normal = {-up.x(), -up.y(), 0.0};
  step.plane.offset_m = -up.dot(a);
  step.outline = {{a.x(), a.y(), low}, {b.x(), b.y(), low}, {b.x(), b.y(), high}, {a.x(), a.y(), high}};
  if (SignedArea(step.outline, step.plane.normal) < 0.0)
    std::reverse(step.outline.begin(), step.outline.end());
  return step;
}

/// How far a step lies from what was seen of its flight, in steps.
class Seen {
 public:
  explicit Seen(const TrackedStaircase& staircase) {
    for (const StepPlace& place : staircase.places) {
      levels_.insert(place.step_index);
      if (place.riser) risers_.insert(place.step_index);
    }
    if (staircase.foot_region != 0) levels_.insert(0);
  }
  double StepsAway(int k) const {
    double least = 1e3;
    for (const int level : levels_) least = std::min(least, std::abs(static_cast<double>(level - k)));
    return least;
  }
  bool HasRisers() const { return !risers_.empty(); }
  bool Riser(int k) const { return risers_.contains(k); }

 private:
  std::set<int> levels_, risers_;
};

}  // namespace

std::vector<InferredStep> InferSteps(const TrackedStaircase& staircase,
                                     const std::vector<RegionShapePtr>& shapes) {
  const FoundStaircase& found = staircase.found;
  const FlightModel& model = found.model;
  const Seen seen(staircase);
  // Strips of several treads in one incline say nothing about where one of them ends.
  std::set<PolygonId> inclines;
  for (const StepPlace& place : staircase.places)
    if (place.only_evidence) inclines.insert(place.region);
  std::vector<const RegionShape*> near;
  for (const RegionShapePtr& shape : shapes)
    if (!inclines.contains(shape->id())) near.push_back(shape.get());

  std::vector<InferredStep> steps;
  const auto add = [&](InferredStep step) {
    constexpr double kOneStep_m = 0.003;  // what is seen of the nearest step is good to this
    const double away = 1.0 + seen.StepsAway(step.step_index);
    step.height_sigma_m = std::hypot(kOneStep_m, away * found.rise_sigma_m);
    step.place_sigma_m = std::hypot(kOneStep_m, away * found.run_sigma_m);
    if (step.height_sigma_m <= kMaxHeightSigma && step.place_sigma_m <= kMaxPlaceSigma)
      steps.push_back(std::move(step));
  };
  // Behind the last riser lies a landing, or one more tread.
  const bool landing_unseen = staircase.head_region == 0 && found.num_treads < found.num_risers;
  const int last_level = found.num_treads + (landing_unseen ? 1 : 0);
  for (int k = 1; k <= found.num_risers; ++k) {
    if (seen.HasRisers() && !seen.Riser(k)) add(Riser(model, k));
    if (k > last_level) continue;
    const std::optional<FreeRectangle> part = UnseenPart(model, k, model.run_m, near);
    if (!part) continue;
    InferredStep tread;
    tread.step_index = k;
    tread.plane = {Eigen::Vector3d::UnitZ(), model.foot_z + k * model.rise_m};
    tread.outline = Level(model, k, *part);
    add(std::move(tread));
  }
  return steps;
}

}  // namespace terrace
