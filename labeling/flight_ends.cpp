// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/flight_ends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/angles.h"
#include "labeling/flight_values.h"
#include "labeling/slope_evidence.h"

namespace terrace {
namespace {

/// A floor or a landing reaches further than this many treads.
constexpr double kLongerThanTread = 1.35;
/// A low robot sees little of the floor before it, and no tread that could be taken for it.
constexpr double kFloorInTreads = 1.15;

/// A support at a height that the flight's law knows.
struct LevelBeside {
  Interval along;
  int level = 0;  ///< 0: at the foot of step 1
  double z = 0.0;
  int shape = 0;
};

std::optional<LevelBeside> MeasureLevel(const StaircaseConfig& config, const RegionShape& s,
                                        const Flight& flight) {
  const Stride& stride = flight.stride;
  if (s.lean != Lean::kSupport || s.slope_rad > Radians(config.max_tread_slope_deg)) return std::nullopt;
  const Interval lateral = flight.frame->LateralExtent(s);
  const double beside = lateral.Overlap(stride.lateral);
  if (beside < 0.4 * std::min(stride.lateral.length(), lateral.length())) return std::nullopt;
  // Where it meets the flight, for it may lean: the end of a floor, the beginning of a landing.
  Interval along = flight.frame->AlongExtent(
      s, {std::max(lateral.low, stride.lateral.low), std::min(lateral.high, stride.lateral.high)});
  const double steps = s.HeightAt(s.rectangle.center) - stride.z0;
  const double hint = stride.along0 + (steps / stride.rise - 0.5) * stride.run;
  const double shift = flight.frame->Unwrapped(along.middle(), hint) - along.middle();
  along = {along.low + shift, along.high + shift};
  const double flight_end = along.middle() < hint ? along.high : along.low;
  const double z = flight.frame->HeightNear(s, flight_end, stride.lateral.middle());
  const int level = static_cast<int>(std::lround((z - stride.z0) / stride.rise));
  if (std::abs(z - stride.z0 - level * stride.rise) > 1.5 * config.HeightTolerance(stride.rise))
    return std::nullopt;
  return LevelBeside{along, level, z, 0};
}

/// All supports at heights that the law knows; pieces of one level that lie one behind the other are one.
std::vector<LevelBeside> LevelsBeside(const StaircaseConfig& config,
                                      const std::vector<RegionShapePtr>& shapes, const Flight& flight) {
  constexpr double kMaxGap = 0.15;  // unseen between two pieces of one floor
  std::vector<LevelBeside> levels;
  for (int i = 0; i < static_cast<int>(shapes.size()); ++i) {
    std::optional<LevelBeside> beside = MeasureLevel(config, *shapes[i], flight);
    if (!beside) continue;
    beside->shape = i;
    levels.push_back(*beside);
  }
  const std::vector<LevelBeside> pieces = levels;
  for (LevelBeside& whole : levels) {
    for (std::size_t round = 0; round < pieces.size(); ++round) {
      const double length = whole.along.length();
      for (const LevelBeside& piece : pieces) {
        if (piece.level != whole.level || piece.along.Overlap(whole.along) < -kMaxGap) continue;
        whole.along = whole.along.Hull(piece.along);
      }
      if (whole.along.length() == length) break;
    }
  }
  return levels;
}

/// So many levels from its lowest step on the rise is known well enough to tell one from the next.
int LevelsKnown(const Flight& flight) {
  constexpr double kShareOfRise = 0.3;
  constexpr int kMost = 12;
  const std::optional<LineFit> heights = FitLine(StepHeights(flight, flight.fits));
  if (!heights) return 1;
  return std::clamp(static_cast<int>(kShareOfRise * flight.stride.rise / heights->slope_sigma), 1, kMost);
}

/// The last riser of a flight whose landing stands on a block: a face in the place of a riser that ends at
/// the height of its level and reaches deeper than a riser does. Of one that goes on higher it would be a
/// wall.
std::optional<int> LastRiserOfBlock(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                                    const Flight& flight, int highest) {
  constexpr double kDeeper = 1.3;  // of the rise
  constexpr double kAcross = 0.6;  // of the width of the flight
  const Stride& stride = flight.stride;
  const double min_cos = std::cos(Radians(config.max_turn_deg));
  for (const int k : {highest, highest + 1}) {
    const double top = stride.z0 + k * stride.rise;
    for (const RegionShapePtr& shape : shapes) {
      if (shape->lean != Lean::kUpright || shape->face_heights.length() < kDeeper * stride.rise) continue;
      if (std::abs(shape->face_heights.high - top) > config.HeightTolerance(stride.rise)) continue;
      if (-shape->front().dot(flight.frame->UpAt(shape->rectangle.center)) < min_cos) continue;
      const Interval lateral = flight.frame->LateralExtent(*shape);
      if (lateral.Overlap(stride.lateral) < kAcross * stride.lateral.length()) continue;
      const double along = flight.frame->AlongExtent(*shape, lateral).middle();
      if (std::abs(flight.frame->Unwrapped(along, stride.EdgeAt(k)) - stride.EdgeAt(k)) <=
          config.edge_tolerance_m)
        return k;
    }
  }
  return std::nullopt;
}

/// True when a face of the flight lies in an incline that goes on as its steps do, and is no plane.
bool MergedIntoIncline(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                       const Flight& flight, int k) {
  constexpr double kAlike_rad = 0.2;
  constexpr double kWithin = 0.6;  // of the rise
  const Stride& stride = flight.stride;
  const Eigen::Vector2d p = flight.frame->PointAt(stride.EdgeAt(k), stride.lateral.middle());
  const double z = stride.z0 + (k - 0.5) * stride.rise;
  const double pitch_rad = std::atan2(stride.rise, stride.run);
  const double min_cos = std::cos(Radians(config.max_turn_deg));
  return std::any_of(shapes.begin(), shapes.end(), [&](const RegionShapePtr& shape) {
    return std::abs(shape->slope_rad - pitch_rad) < kAlike_rad && DepartsFromPlane(*shape, config) &&
           -shape->plane.normal.head<2>().normalized().dot(flight.frame->UpAt(p)) >= min_cos &&
           shape->PlanDistance(p) <= 0.0 && std::abs(shape->HeightAt(p) - z) < kWithin * stride.rise;
  });
}

}  // namespace

void KeepLongestRun(std::vector<StepFit>& fits) {
  std::set<int> levels;
  for (const StepFit& fit : fits) levels.insert(fit.step_index);
  std::vector<std::pair<int, int>> runs;
  for (const int level : levels) {
    if (runs.empty() || level - runs.back().second > 3)
      runs.emplace_back(level, level);
    else
      runs.back().second = level;
  }
  std::pair<int, int> best{0, -1};
  std::ptrdiff_t most = 0;
  for (const auto& run : runs) {
    const auto n = std::count_if(fits.begin(), fits.end(), [&](const StepFit& fit) {
      return fit.step_index >= run.first && fit.step_index <= run.second;
    });
    if (n > most) {
      most = n;
      best = run;
    }
  }
  std::erase_if(
      fits, [&](const StepFit& fit) { return fit.step_index < best.first || fit.step_index > best.second; });
}

FlightEnds FindFlightEnds(const StaircaseConfig& config, const std::vector<RegionShapePtr>& shapes,
                          const Flight& flight, double ground_z) {
  const Stride& stride = flight.stride;
  int lowest = std::numeric_limits<int>::max();
  int highest = std::numeric_limits<int>::min();
  for (const StepFit& fit : flight.fits) {
    if (flight.elements[fit.element].landing) continue;
    lowest = std::min(lowest, fit.step_index);
    highest = std::max(highest, fit.step_index);
  }
  if (highest < lowest) return {};
  const bool highest_is_tread = std::any_of(flight.fits.begin(), flight.fits.end(), [&](const StepFit& fit) {
    const StepElement& e = flight.elements[fit.element];
    return fit.step_index == highest && !e.riser && !e.landing;
  });

  const int most_away = LevelsKnown(flight);
  // Supports at the right height that reach further than a tread does.
  FlightEnds ends;
  std::optional<LevelHeight> foot, head;
  double foot_gap = std::numeric_limits<double>::infinity();
  double head_gap = std::numeric_limits<double>::infinity();
  const double slack = 2.0 * config.edge_tolerance_m;
  const double long_enough = kLongerThanTread * stride.run;
  for (const auto& [along, level, z, shape] : LevelsBeside(config, shapes, flight)) {
    const bool at_feet = std::abs(stride.z0 + level * stride.rise - ground_z) < 0.3 * stride.rise;
    if (!at_feet && along.length() <= kFloorInTreads * stride.run) continue;
    const double edge = stride.EdgeAt(level);  // riser below this level
    // A landing begins at the riser below its level, a floor ends at the riser above it.
    const double before = along.low - edge;
    const double behind = edge + stride.run - along.high;
    if (level >= highest - 1 && level <= highest + 1 && before > -slack && before < stride.run &&
        along.length() > long_enough && along.high > edge + long_enough && std::abs(before) < head_gap) {
      head_gap = std::abs(before);
      head = LevelHeight{level, z, LevelHeightSigma(*shapes[shape])};
      ends.head_shape = shape;
    }
    // A floor that is long before the flight may go on beneath open steps.
    const bool beneath = behind <= -slack && along.low < edge + stride.run - long_enough;
    const double to_flight = beneath ? 0.0 : std::abs(behind);
    if (level < lowest + 1 && level >= lowest - most_away && (beneath || behind > -slack) &&
        behind < 4.0 * stride.run && (at_feet || along.low < edge - 0.1 * stride.run) &&
        to_flight < foot_gap) {
      foot_gap = to_flight;
      foot = LevelHeight{level, z, LevelHeightSigma(*shapes[shape])};
      ends.foot_shape = shape;
    }
  }
  ends.first_step = foot ? foot->level + 1 : lowest;
  const std::optional<int> block = head ? std::nullopt : LastRiserOfBlock(config, shapes, flight, highest);
  ends.last_step = head ? head->level : block.value_or(highest);
  ends.ends_with_tread = !head && !block && highest_is_tread;
  if (!head && !block) {
    // One step between may have merged otherwise.
    const auto merged = [&](int k) { return MergedIntoIncline(config, shapes, flight, ends.last_step + k); };
    while (merged(ends.num_merged + 1) || merged(ends.num_merged + 2)) ++ends.num_merged;
  }
  if (foot) ends.heights.push_back(*foot);
  if (head) ends.heights.push_back(*head);
  return ends;
}

}  // namespace terrace
