// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "core/angles.h"

namespace terrace {
namespace {

constexpr double kPi = std::numbers::pi;
Eigen::Vector2d LeftOf(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }
double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A surface that may be a step.
struct Candidate {
  int surface = 0;
  bool riser = false;
  bool spiral_only = false;  ///< too deep for a straight tread, but a wedge is deeper at its outer end
};

/// A candidate seen along a flight: every length is measured up the stairs from some origin (of a spiral:
/// along the circle of its middle radius) or across them.
struct Element {
  int surface = 0;
  bool riser = false;
  Interval along;    ///< of a riser: its middle, twice
  Interval lateral;  ///< straight: to the left; spiral: distance from the axis
  Interval heights;
  double z = 0.0;  ///< middle height of a riser, mean height of a tread
  double area_m2 = 0.0;
};

/// The part of a FlightModel that is searched for when direction or axis are given.
struct Stride {
  double along0 = 0.0;  ///< of riser 1
  double run = 0.0;
  double z0 = 0.0;  ///< foot of riser 1
  double rise = 0.0;
  Interval lateral;
};

/// An element that obeys a stride.
struct Fit {
  int element = 0;
  int step_index = 0;
  double quality = 0.0;  ///< 1 perfect, 0 at the tolerance
};

/// One hypothesis with everything that obeys it.
struct Flight {
  FlightModel frame;  ///< direction and origin, or axis and radius, in which `elements` are measured
  std::vector<Element> elements;
  Stride stride;
  std::vector<Fit> fits;
  double score = 0.0;
};

/// How far along a line or a circle; of a circle the turn nearest to `hint_m`.
double Unwrapped(double along_m, double hint_m, double period_m) {
  if (period_m <= 0.0) return along_m;
  return along_m + period_m * std::round((hint_m - along_m) / period_m);
}

class FlightSearch {
 public:
  FlightSearch(const StaircaseConfig& config, const std::vector<SurfacePtr>& surfaces)
      : config_(config), surfaces_(surfaces) {}

  std::vector<Candidate> Candidates() const;
  std::vector<FlightModel> StraightFrames(const std::vector<Candidate>& candidates) const;
  std::vector<FlightModel> SpiralFrames(const std::vector<Candidate>& candidates) const;
  std::vector<Element> Measure(const std::vector<Candidate>& candidates, const FlightModel& frame) const;
  std::optional<Flight> BestStride(const FlightModel& frame, const std::vector<Element>& elements) const;
  std::optional<Flight> Follow(const FlightModel& known, const std::vector<Candidate>& candidates) const;
  std::optional<FoundStaircase> Complete(Flight flight, bool known) const;

 private:
  static double Period(const FlightModel& frame) { return frame.spiral ? 2.0 * kPi * frame.radius_m : 0.0; }
  bool Plausible(const Stride& stride) const;
  std::optional<Fit> Place(const Element& element, const Stride& stride, double period) const;
  double Collect(const std::vector<Element>& elements, const Stride& stride, double period,
                 std::vector<Fit>* fits) const;
  void Refine(Flight& flight) const;
  std::optional<Flight> TurnToMembers(const Flight& flight) const;
  Interval AlongExtent(const Surface& surface, const FlightModel& frame, const Interval& lateral) const;
  Interval LateralExtent(const Surface& surface, const FlightModel& frame) const;
  double HeightNear(const Surface& surface, const FlightModel& frame, double along, double lateral) const;

  const StaircaseConfig& config_;
  const std::vector<SurfacePtr>& surfaces_;
};

std::vector<Candidate> FlightSearch::Candidates() const {
  // A riser may be seen with a strip of what stands above or below it.
  const double max_face = config_.max_riser_m + 2.0 * config_.height_tolerance_m;
  // A landing of which little is seen may pass for a tread; its neighbours tell.
  const double max_depth = config_.max_tread_m + 2.0 * config_.edge_tolerance_m;
  constexpr double kMinFaceHeight = 0.03;
  constexpr double kMinDepth = 0.06;
  // Fragments of a step, in pieces.
  constexpr double kMinLength = 0.2;
  std::vector<Candidate> candidates;
  for (int i = 0; i < static_cast<int>(surfaces_.size()); ++i) {
    const Surface& s = *surfaces_[i];
    if (s.rectangle.length_m < kMinLength) continue;
    if (s.lean == Lean::kUpright) {
      const double height = s.face_heights.length();
      if (height >= kMinFaceHeight && height <= max_face) candidates.push_back({i, true});
    } else if (s.lean == Lean::kSupport) {
      const double depth = s.rectangle.depth_m;
      if (s.slope_rad <= Radians(config_.max_tread_slope_deg) && depth >= kMinDepth &&
          depth <= 2.0 * max_depth)
        candidates.push_back({i, false, depth > max_depth});
    }
  }
  return candidates;
}

std::vector<FlightModel> FlightSearch::StraightFrames(const std::vector<Candidate>& candidates) const {
  struct Vote {
    Eigen::Vector2d direction;
    double weight;
  };
  std::vector<Vote> votes;
  for (const Candidate& c : candidates) {
    const Surface& s = *surfaces_[c.surface];
    if (c.riser) {
      votes.push_back({-s.front(), s.area_m2});
    } else if (!c.spiral_only && s.rectangle.length_m > 1.5 * s.rectangle.depth_m) {
      votes.push_back({s.rectangle.short_axis(), s.area_m2});
      votes.push_back({-s.rectangle.short_axis(), s.area_m2});
    }
  }
  std::stable_sort(votes.begin(), votes.end(),
                   [](const Vote& a, const Vote& b) { return a.weight > b.weight; });
  constexpr std::size_t kMaxFrames = 12;
  const double same = std::cos(Radians(0.5 * config_.max_turn_deg));
  std::vector<Eigen::Vector2d> sums;
  for (const Vote& vote : votes) {
    const auto cluster = std::find_if(sums.begin(), sums.end(), [&](const Eigen::Vector2d& sum) {
      return sum.normalized().dot(vote.direction) >= same;
    });
    if (cluster != sums.end())
      *cluster += vote.weight * vote.direction;
    else if (sums.size() < kMaxFrames)
      sums.push_back(vote.weight * vote.direction);
  }
  std::vector<FlightModel> frames;
  for (const Eigen::Vector2d& sum : sums) {
    FlightModel frame;
    frame.direction = sum.normalized();
    frames.push_back(frame);
  }
  return frames;
}

/// Where two lines of the plan meet; none when they are nearly parallel.
std::optional<Eigen::Vector2d> Meeting(const Eigen::Vector2d& p, const Eigen::Vector2d& u,
                                       const Eigen::Vector2d& q, const Eigen::Vector2d& v) {
  const double minimum = std::sin(Radians(7.0));
  const double sine = Cross(u, v);
  if (std::abs(sine) < minimum) return std::nullopt;
  return p + u * (Cross(q - p, v) / sine);
}

std::vector<FlightModel> FlightSearch::SpiralFrames(const std::vector<Candidate>& candidates) const {
  constexpr std::size_t kMaxFrames = 12;
  constexpr double kMinRadius = 0.3;
  constexpr double kMaxRadius = 3.0;
  constexpr double kSameAxis = 0.15;
  std::vector<FlightModel> frames;
  const auto add = [&](const Eigen::Vector2d& axis, double radius) {
    if (radius < kMinRadius || radius > kMaxRadius || frames.size() >= 2 * kMaxFrames) return;
    for (const FlightModel& f : frames)
      if ((f.origin - axis).norm() < kSameAxis && std::abs(f.radius_m - radius) < kSameAxis) return;
    FlightModel frame;
    frame.spiral = true;
    frame.origin = axis;
    frame.radius_m = radius;
    frames.push_back(frame);
    frame.turn_sign = -1.0;
    frames.push_back(frame);
  };
  // The planes of the risers pass through the axis: neighbours in height tell where.
  for (const Candidate& a : candidates) {
    for (const Candidate& b : candidates) {
      if (!a.riser || !b.riser) continue;
      const Surface& low = *surfaces_[a.surface];
      const Surface& high = *surfaces_[b.surface];
      const double rise = high.face_heights.middle() - low.face_heights.middle();
      if (rise < config_.min_riser_m || rise > config_.max_riser_m) continue;
      const Eigen::Vector2d p = low.rectangle.center;
      const Eigen::Vector2d q = high.rectangle.center;
      if ((q - p).norm() > 2.0 * config_.max_tread_m || low.front().dot(high.front()) < 0.5) continue;
      if (const auto axis = Meeting(p, low.face_axis, q, high.face_axis))
        add(*axis, 0.5 * ((p - *axis).norm() + (q - *axis).norm()));
    }
  }
  // The two long sides of a tread meet at the axis as well: that is all there is from above.
  for (const Candidate& c : candidates) {
    if (c.riser) continue;
    const PlanRing& ring = surfaces_[c.surface]->plan.front();
    std::vector<std::pair<double, std::size_t>> sides;  // minus length, index
    for (std::size_t i = 0; i < ring.size(); ++i)
      sides.emplace_back(-(ring[(i + 1) % ring.size()] - ring[i]).norm(), i);
    std::sort(sides.begin(), sides.end());
    const auto side = [&](int n) {
      return ring[(sides[n].second + 1) % ring.size()] - ring[sides[n].second];
    };
    if (sides.size() < 3 || -sides[1].first < config_.min_width_m) continue;
    if (const auto axis =
            Meeting(ring[sides[0].second], side(0).normalized(), ring[sides[1].second], side(1).normalized()))
      add(*axis, (surfaces_[c.surface]->rectangle.center - *axis).norm());
  }
  return frames;
}

/// @param lateral  of the flight, or of the surface itself: what lies beside it does not count
Interval FlightSearch::AlongExtent(const Surface& surface, const FlightModel& frame,
                                   const Interval& lateral) const {
  if (!frame.spiral) return MiddleExtent(surface.plan.front(), frame.direction, lateral);
  // Angles relative to the middle of the surface, so that none jumps by a full turn.
  const Eigen::Vector2d middle = surface.rectangle.center - frame.origin;
  const double middle_angle = std::atan2(middle.y(), middle.x());
  Interval turn{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Eigen::Vector2d& p : surface.plan.front()) {
    const Eigen::Vector2d arm = p - frame.origin;
    const double angle = std::atan2(Cross(middle, arm), middle.dot(arm));
    turn.low = std::min(turn.low, frame.turn_sign * angle);
    turn.high = std::max(turn.high, frame.turn_sign * angle);
  }
  const double start = frame.turn_sign * middle_angle;
  return {(start + turn.low) * frame.radius_m, (start + turn.high) * frame.radius_m};
}

Interval FlightSearch::LateralExtent(const Surface& surface, const FlightModel& frame) const {
  if (!frame.spiral) return Extent(surface.plan.front(), LeftOf(frame.direction));
  Interval radius{std::numeric_limits<double>::infinity(), 0.0};
  for (const Eigen::Vector2d& p : surface.plan.front()) {
    radius.low = std::min(radius.low, (p - frame.origin).norm());
    radius.high = std::max(radius.high, (p - frame.origin).norm());
  }
  return radius;
}

/// Height of a support where it comes nearest to a place of the flight.
double FlightSearch::HeightNear(const Surface& surface, const FlightModel& frame, double along,
                                double lateral) const {
  Eigen::Vector2d p = frame.direction * along + LeftOf(frame.direction) * lateral;
  if (frame.spiral) {
    const double angle = frame.turn_sign * along / frame.radius_m;
    p = frame.origin + lateral * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  Eigen::Vector2d nearest;
  surface.PlanDistance(p, &nearest);
  return surface.HeightAt(nearest);
}

std::vector<Element> FlightSearch::Measure(const std::vector<Candidate>& candidates,
                                           const FlightModel& frame) const {
  const double min_cos_riser = std::cos(Radians(config_.max_turn_deg));
  // The outline of a tread that is partly seen leans with the limit of view.
  const double min_cos_tread = std::cos(Radians(2.0 * config_.max_turn_deg));
  std::vector<Element> elements;
  for (const Candidate& c : candidates) {
    if (c.spiral_only && !frame.spiral) continue;
    const Surface& s = *surfaces_[c.surface];
    const Eigen::Vector2d arm = (s.rectangle.center - frame.origin).normalized();
    const Eigen::Vector2d up =
        frame.spiral ? Eigen::Vector2d(frame.turn_sign * LeftOf(arm)) : frame.direction;
    if (c.riser && -s.front().dot(up) < min_cos_riser) continue;
    if (!c.riser && !frame.spiral && s.rectangle.length_m > 2.0 * s.rectangle.depth_m &&
        std::abs(s.rectangle.short_axis().dot(up)) < min_cos_tread)
      continue;
    Element e;
    e.surface = c.surface;
    e.riser = c.riser;
    e.lateral = LateralExtent(s, frame);
    e.along = AlongExtent(s, frame, e.lateral);
    if (c.riser) e.along = {e.along.middle(), e.along.middle()};
    e.heights = c.riser ? s.face_heights : s.heights();
    e.z = c.riser ? e.heights.middle() : s.HeightAt(s.rectangle.center);
    e.area_m2 = s.area_m2;
    elements.push_back(e);
  }
  return elements;
}

bool FlightSearch::Plausible(const Stride& stride) const {
  if (stride.rise < config_.min_riser_m || stride.rise > config_.max_riser_m) return false;
  if (stride.run < config_.min_tread_m || stride.run > config_.max_tread_m) return false;
  const double pitch = std::atan2(stride.rise, stride.run);
  return pitch >= Radians(config_.min_pitch_deg) && pitch <= Radians(config_.max_pitch_deg);
}

std::optional<Fit> FlightSearch::Place(const Element& e, const Stride& stride, double period) const {
  const double beside = e.lateral.Overlap(stride.lateral);
  if (beside < 0.4 * std::min(e.lateral.length(), stride.lateral.length())) return std::nullopt;
  // Heights are better than depths: they choose the step.
  const double steps_up = (e.z - stride.z0) / stride.rise;
  const int k = static_cast<int>(std::lround(e.riser ? steps_up + 0.5 : steps_up));
  const double edge = stride.along0 + (k - 1) * stride.run;
  const double z_low = stride.z0 + (k - 1) * stride.rise;
  const double z_high = z_low + stride.rise;
  const double shift = Unwrapped(e.along.low, edge, period) - e.along.low;
  const double low = e.along.low + shift;
  const double high = e.along.high + shift;
  double strain = 0.0;  // of the worst measure, in tolerances
  if (e.riser) {
    strain = std::abs(low - edge) / config_.edge_tolerance_m;
    // Rounded edges and strips of the neighbours: twice the tolerance at the ends of a face.
    const double beyond = std::max(z_low - e.heights.low, e.heights.high - z_high);
    strain = std::max(strain, 0.5 * beyond / config_.height_tolerance_m);
  } else {
    strain = std::abs(e.z - z_high) / config_.height_tolerance_m;
    // What is hidden makes a tread shorter, never longer.
    strain = std::max(strain, (edge - low) / config_.edge_tolerance_m);
    strain = std::max(strain, (high - (edge + stride.run)) / config_.edge_tolerance_m);
    if (std::min(high, edge + stride.run) - std::max(low, edge) < 0.25 * stride.run) return std::nullopt;
  }
  if (strain > 1.0) return std::nullopt;
  return Fit{0, k, 1.0 - strain};
}

double FlightSearch::Collect(const std::vector<Element>& elements, const Stride& stride, double period,
                             std::vector<Fit>* fits) const {
  // Each riser and each tread counts once, however many fragments it has.
  std::map<std::pair<int, bool>, double> best;
  for (int i = 0; i < static_cast<int>(elements.size()); ++i) {
    std::optional<Fit> fit = Place(elements[i], stride, period);
    if (!fit) continue;
    fit->element = i;
    double& quality = best[{fit->step_index, elements[i].riser}];
    quality = std::max(quality, 0.5 + 0.5 * fit->quality);
    if (fits) fits->push_back(*fit);
  }
  double score = 0.0;
  for (const auto& [step, quality] : best) score += quality;
  return score;
}

std::optional<Flight> FlightSearch::BestStride(const FlightModel& frame,
                                               const std::vector<Element>& elements) const {
  constexpr double kMinScore = 1.5;  // the two elements that make the hypothesis obey it anyhow
  const double period = Period(frame);
  Flight best{frame, elements, {}, {}, kMinScore};
  const auto consider = [&](const Element& low, double edge_low, const Element& high, double edge_high,
                            double z_low_edge) {
    for (int steps = 1; steps <= 2; ++steps) {
      Stride stride;
      stride.rise = (high.z - low.z) / steps;
      if (stride.rise < config_.min_riser_m || stride.rise > config_.max_riser_m) continue;
      const double hint = edge_low + steps * 0.5 * (config_.min_tread_m + config_.max_tread_m);
      stride.run = (Unwrapped(edge_high, hint, period) - edge_low) / steps;
      stride.along0 = edge_low;
      stride.z0 = low.riser ? z_low_edge - 0.5 * stride.rise : z_low_edge - stride.rise;
      if (!Plausible(stride)) continue;
      stride.lateral = {std::min(low.lateral.low, high.lateral.low),
                        std::max(low.lateral.high, high.lateral.high)};
      const double score = Collect(elements, stride, period, nullptr);
      if (score > best.score) {
        best.score = score;
        best.stride = stride;
      }
    }
  };
  for (const Element& low : elements) {
    for (const Element& high : elements) {
      if (low.riser != high.riser || high.z <= low.z) continue;
      if (low.lateral.Overlap(high.lateral) < 0.5 * config_.min_width_m) continue;
      consider(low, low.along.low, high, high.along.low, low.z);
      // When the front of a tread is hidden its back may be seen.
      if (!low.riser) {
        const double run = high.along.high - low.along.high;
        consider(low, low.along.high - run, high, low.along.high, low.z);
      }
    }
  }
  if (best.stride.rise <= 0.0) return std::nullopt;
  Refine(best);
  // The direction was a rough vote of everything about: its own members know better.
  std::optional<Flight> turned = TurnToMembers(best);
  return turned && turned->score > best.score - 0.5 ? turned : best;
}

/// The same straight flight, measured along the direction on which its risers (none: its treads) agree.
std::optional<Flight> FlightSearch::TurnToMembers(const Flight& flight) const {
  if (flight.frame.spiral || flight.fits.empty()) return std::nullopt;
  Eigen::Vector2d risers = Eigen::Vector2d::Zero();
  Eigen::Vector2d treads = Eigen::Vector2d::Zero();
  std::vector<Candidate> members;
  for (const Fit& fit : flight.fits) {
    const Element& e = flight.elements[fit.element];
    const Surface& s = *surfaces_[e.surface];
    members.push_back({e.surface, e.riser});
    if (e.riser) {
      risers -= s.area_m2 * s.front();
    } else {
      const Eigen::Vector2d across = s.rectangle.short_axis();
      treads += s.area_m2 * (across.dot(flight.frame.direction) > 0.0 ? across : Eigen::Vector2d(-across));
    }
  }
  const Eigen::Vector2d sum = risers.isZero() ? treads : risers;
  if (sum.norm() <= 0.0) return std::nullopt;
  Flight turned;
  turned.frame.direction = sum.normalized();
  turned.stride = flight.stride;
  turned.elements = Measure(members, turned.frame);
  // Where each member says that the foot edge is.
  double feet = 0.0, weight = 0.0;
  Interval lateral{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Element& e : turned.elements) {
    const auto fit = std::find_if(flight.fits.begin(), flight.fits.end(), [&](const Fit& f) {
      return flight.elements[f.element].surface == e.surface;
    });
    const double trust = e.riser ? 1.0 : 0.3;  // as in Refine
    feet += trust * (e.along.low - (fit->step_index - 1) * flight.stride.run);
    weight += trust;
    lateral = {std::min(lateral.low, e.lateral.low), std::max(lateral.high, e.lateral.high)};
  }
  if (weight <= 0.0) return std::nullopt;
  turned.stride.along0 = feet / weight;
  turned.stride.lateral = lateral;
  Refine(turned);
  return turned;
}

/// Least squares of y = a + b x with weights; none when all x are equal.
std::optional<std::pair<double, double>> FitLine(const std::vector<std::array<double, 3>>& xyw) {
  double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const auto& [xi, yi, wi] : xyw) {
    w += wi;
    x += wi * xi;
    y += wi * yi;
  }
  if (w <= 0.0) return std::nullopt;
  x /= w;
  y /= w;
  for (const auto& [xi, yi, wi] : xyw) {
    xx += wi * (xi - x) * (xi - x);
    xy += wi * (xi - x) * (yi - y);
  }
  if (xx < 1e-9) return std::nullopt;
  return std::pair(y - xy / xx * x, xy / xx);
}

void FlightSearch::Refine(Flight& flight) const {
  constexpr int kRounds = 3;
  const double period = Period(flight.frame);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Fit> fits;
    Collect(flight.elements, flight.stride, period, &fits);
    // The same weight for every step, whatever the number of its fragments.
    std::map<std::pair<int, bool>, double> area;
    for (const Fit& fit : fits)
      area[{fit.step_index, flight.elements[fit.element].riser}] += flight.elements[fit.element].area_m2;
    std::vector<std::array<double, 3>> heights, edges;
    // Of a face both ends are seen from afar, of a tread often only a part.
    std::vector<Interval> widths;
    const bool any_riser = std::any_of(fits.begin(), fits.end(),
                                       [&](const Fit& fit) { return flight.elements[fit.element].riser; });
    for (const Fit& fit : fits) {
      const Element& e = flight.elements[fit.element];
      const double weight = e.area_m2 / std::max(1e-9, area[{fit.step_index, e.riser}]);
      const double edge = flight.stride.along0 + (fit.step_index - 1) * flight.stride.run;
      const double along = Unwrapped(e.along.low, edge, period);
      // The top and bottom of a face are worse known than the height of a level piece; the front of a tread
      // is worse known than the place of a face.
      if (e.riser) {
        heights.push_back({fit.step_index - 0.5, e.z, 0.2 * weight});
        edges.push_back({fit.step_index - 1.0, along, weight});
      } else {
        heights.push_back({static_cast<double>(fit.step_index), e.z, weight});
        edges.push_back({fit.step_index - 1.0, along, 0.3 * weight});
      }
      if (e.riser == any_riser) widths.push_back(e.lateral);
    }
    const auto z = FitLine(heights);
    const auto along = FitLine(edges);
    if (!z || !along) break;
    Stride refined{along->first, along->second, z->first, z->second, flight.stride.lateral};
    // A few are cut off by the limit of view, and a few run on beside the stairs: the middle one of the ends.
    const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
    std::nth_element(widths.begin(), middle, widths.end(),
                     [](const Interval& a, const Interval& b) { return a.high < b.high; });
    refined.lateral.high = middle->high;
    std::nth_element(widths.begin(), middle, widths.end(),
                     [](const Interval& a, const Interval& b) { return a.low < b.low; });
    refined.lateral.low = middle->low;
    if (!Plausible(refined) || refined.lateral.length() <= 0.0) break;
    if (Collect(flight.elements, refined, period, nullptr) < flight.score - 0.5) break;
    flight.stride = refined;
  }
  flight.fits.clear();
  flight.score = Collect(flight.elements, flight.stride, period, &flight.fits);
}

std::optional<Flight> FlightSearch::Follow(const FlightModel& known,
                                           const std::vector<Candidate>& candidates) const {
  Flight flight;
  flight.frame = known;
  if (!known.spiral) flight.frame.origin = Eigen::Vector2d::Zero();
  flight.elements = Measure(candidates, flight.frame);
  flight.stride = {0.0, known.run_m, known.foot_z, known.rise_m, known.lateral};
  if (known.spiral) {
    flight.stride.along0 =
        known.turn_sign * std::atan2(known.direction.y(), known.direction.x()) * known.radius_m;
  } else {
    const double shift = LeftOf(known.direction).dot(known.origin);
    flight.stride.along0 = known.direction.dot(known.origin);
    flight.stride.lateral = {known.lateral.low + shift, known.lateral.high + shift};
  }
  Refine(flight);
  if (flight.fits.empty()) return std::nullopt;
  std::optional<Flight> turned = TurnToMembers(flight);
  return turned && turned->score > flight.score - 0.5 ? turned : flight;
}

/// Cuts a chain of steps where two levels in a row are missing, keeps the piece with most elements.
void KeepLongestRun(std::vector<Fit>& fits) {
  std::set<int> levels;
  for (const Fit& fit : fits) levels.insert(fit.step_index);
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
    const auto n = std::count_if(fits.begin(), fits.end(), [&](const Fit& fit) {
      return fit.step_index >= run.first && fit.step_index <= run.second;
    });
    if (n > most) {
      most = n;
      best = run;
    }
  }
  std::erase_if(fits,
                [&](const Fit& fit) { return fit.step_index < best.first || fit.step_index > best.second; });
}

std::optional<FoundStaircase> FlightSearch::Complete(Flight flight, bool known) const {
  const double period = Period(flight.frame);
  Stride& stride = flight.stride;
  KeepLongestRun(flight.fits);
  if (flight.fits.empty()) return std::nullopt;
  int lowest = std::numeric_limits<int>::max();
  int highest = std::numeric_limits<int>::min();
  bool highest_is_tread = false;
  for (const Fit& fit : flight.fits) {
    lowest = std::min(lowest, fit.step_index);
    highest = std::max(highest, fit.step_index);
  }
  for (const Fit& fit : flight.fits)
    highest_is_tread |= fit.step_index == highest && !flight.elements[fit.element].riser;

  // The floor at the foot and the landing at the head are supports at the right height that reach further
  // than a tread does.
  FoundStaircase found;
  std::optional<int> foot_level, head_level;
  double foot_gap = std::numeric_limits<double>::infinity();
  double head_gap = std::numeric_limits<double>::infinity();
  const double slack = 2.0 * config_.edge_tolerance_m;
  for (int i = 0; i < static_cast<int>(surfaces_.size()); ++i) {
    const Surface& s = *surfaces_[i];
    if (s.lean != Lean::kSupport || s.slope_rad > Radians(config_.max_tread_slope_deg)) continue;
    const Interval lateral = LateralExtent(s, flight.frame);
    if (lateral.Overlap(stride.lateral) < 0.4 * stride.lateral.length()) continue;
    // Where it meets the flight, for it may lean: the end of a floor, the beginning of a landing.
    Interval along =
        AlongExtent(s, flight.frame,
                    {std::max(lateral.low, stride.lateral.low), std::min(lateral.high, stride.lateral.high)});
    const double steps = s.HeightAt(s.rectangle.center) - stride.z0;
    const double hint = stride.along0 + (steps / stride.rise - 0.5) * stride.run;
    const double shift = Unwrapped(along.middle(), hint, period) - along.middle();
    along = {along.low + shift, along.high + shift};
    const double flight_end = along.middle() < hint ? along.high : along.low;
    const double z = HeightNear(s, flight.frame, flight_end, stride.lateral.middle());
    const int level = static_cast<int>(std::lround((z - stride.z0) / stride.rise));
    if (std::abs(z - stride.z0 - level * stride.rise) > 1.5 * config_.height_tolerance_m) continue;
    const double edge = stride.along0 + (level - 1) * stride.run;  // riser below this level
    // A landing begins at the riser below its level, a floor ends at the riser above it.
    const double before = along.low - edge;
    const double behind = edge + stride.run - along.high;
    const bool long_enough = along.length() > 1.35 * stride.run;
    if (long_enough && level >= highest - 1 && level <= highest + 1 && before > -slack &&
        before < stride.run && along.high > edge + 1.35 * stride.run && std::abs(before) < head_gap) {
      head_gap = std::abs(before);
      head_level = level;
      found.head_surface = i;
    }
    if (long_enough && level < lowest + 1 && level >= lowest - 4 && behind > -slack &&
        behind < 4.0 * stride.run && along.low < edge - 0.35 * stride.run && std::abs(behind) < foot_gap) {
      foot_gap = std::abs(behind);
      foot_level = level;
      found.foot_surface = i;
    }
  }
  const int first = foot_level ? *foot_level + 1 : lowest;
  const int last = head_level ? *head_level : highest;
  found.num_risers = last - first + 1;
  found.num_treads = head_level || !highest_is_tread ? found.num_risers - 1 : found.num_risers;
  if (found.num_risers < 2 || found.num_treads < 1) return std::nullopt;

  // Members, and how well they obey.
  std::set<std::pair<int, bool>> distinct;
  std::set<int> levels;
  double sum_z2 = 0.0, sum_a2 = 0.0;
  int num_z = 0, num_a = 0;
  for (const Fit& fit : flight.fits) {
    const Element& e = flight.elements[fit.element];
    const int k = fit.step_index - first + 1;
    if (k < 1 || k > (e.riser ? found.num_risers : found.num_treads)) continue;
    // A wall that goes on beside and above its riser in one plane shows the riser, but is a wall.
    const double in_riser_m2 = e.lateral.Overlap(stride.lateral) * stride.rise;
    if (!e.riser || e.area_m2 <= 2.0 * in_riser_m2) found.members.push_back({e.surface, e.riser, k});
    distinct.insert({k, e.riser});
    levels.insert(k);
    const double edge = stride.along0 + (fit.step_index - 1) * stride.run;
    if (e.riser) {
      const double d = Unwrapped(e.along.low, edge, period) - edge;
      sum_a2 += d * d;
      ++num_a;
    } else {
      const double d = e.z - stride.z0 - fit.step_index * stride.rise;
      sum_z2 += d * d;
      ++num_z;
    }
  }
  std::sort(found.members.begin(), found.members.end(),
            [](const StepMember& a, const StepMember& b) { return a.surface < b.surface; });

  const double width = stride.lateral.length();
  const double seen = static_cast<double>(distinct.size()) / (found.num_risers + found.num_treads);
  const bool both_ends = found.foot_surface && found.head_surface;
  if (width < config_.min_width_m || levels.size() < 2) return std::nullopt;
  // Floor and landing in their places are evidence as well. Direction, rise, run and place of a flight can be
  // chosen so that almost any three surfaces obey.
  const int num_seen =
      static_cast<int>(distinct.size()) + (found.foot_surface ? 1 : 0) + (found.head_surface ? 1 : 0);
  if (found.members.empty() || distinct.size() < 2 || num_seen < (known ? 3 : 4)) return std::nullopt;
  if (seen < (known ? 0.3 : 0.45)) return std::nullopt;
  // Two boxes make two risers as well: then floor, landing and all that lies between must be there.
  if (found.num_risers == 2 && !(both_ends && distinct.size() >= 3)) return std::nullopt;

  FlightModel& model = found.model;
  model = flight.frame;
  model.rise_m = stride.rise;
  model.run_m = stride.run;
  model.foot_z = stride.z0 + (first - 1) * stride.rise;
  model.lateral = stride.lateral;
  const double foot = stride.along0 + (first - 1) * stride.run;
  if (model.spiral) {
    const double angle = model.turn_sign * foot / model.radius_m;
    model.direction = {std::cos(angle), std::sin(angle)};
  } else {
    model.origin = model.direction * foot + LeftOf(model.direction) * stride.lateral.middle();
    model.lateral = {-0.5 * width, 0.5 * width};
  }
  // A spread from few steps is worth little: a centimetre is known beforehand.
  constexpr double kPriorSigma = 0.01;
  const double prior2 = kPriorSigma * kPriorSigma;
  const double span = std::max(1, found.num_risers - 1);
  const double spread_z = std::sqrt((sum_z2 + prior2) / (num_z + 1));
  const double spread_a = std::sqrt((sum_a2 + 4.0 * prior2) / (num_a + 1));
  found.rise_sigma_m = spread_z / span;
  found.run_sigma_m = spread_a / span;
  const double enough = 1.0 - std::exp(-0.5 * (num_seen - 1.0));
  const double good = std::exp(-0.25 * std::pow(spread_z / config_.height_tolerance_m, 2));
  found.confidence = std::clamp(enough * good * (0.6 + 0.4 * seen), 0.0, 1.0);
  if (found.confidence < (known ? 0.6 : 1.0) * config_.min_confidence) return std::nullopt;
  return found;
}

}  // namespace

Eigen::Vector2d FlightModel::UpAt(double k) const {
  if (!spiral) return direction;
  const double angle = turn_sign * run_m / radius_m * (k - 1.0);
  const Eigen::Vector2d arm(direction.x() * std::cos(angle) - direction.y() * std::sin(angle),
                            direction.x() * std::sin(angle) + direction.y() * std::cos(angle));
  return turn_sign * LeftOf(arm);
}

Eigen::Vector2d FlightModel::EdgePoint(double k, double lateral_m) const {
  if (!spiral) return origin + direction * (run_m * (k - 1.0)) + LeftOf(direction) * lateral_m;
  const Eigen::Vector2d up = UpAt(k);
  // Up is left of the arm when the flight turns left.
  return origin - turn_sign * LeftOf(up) * lateral_m;
}

std::vector<std::string> StaircaseConfig::Problems() const {
  std::vector<std::string> problems;
  const auto need = [&](bool holds, const char* rule) {
    if (!holds) problems.emplace_back(rule);
  };
  need(min_riser_m > 0.0 && min_riser_m < max_riser_m, "min_riser_m must lie between 0 and max_riser_m");
  need(min_tread_m > 0.0 && min_tread_m < max_tread_m, "min_tread_m must lie between 0 and max_tread_m");
  need(min_pitch_deg > 0.0 && min_pitch_deg < max_pitch_deg && max_pitch_deg < 90.0,
       "min_pitch_deg and max_pitch_deg must rise between 0 and 90");
  need(min_width_m > 0.0, "min_width_m must be positive");
  need(min_confidence >= 0.0 && min_confidence < 1.0, "min_confidence must lie between 0 and 1");
  need(height_tolerance_m > 0.0 && height_tolerance_m < 0.5 * min_riser_m,
       "height_tolerance_m must lie between 0 and half of min_riser_m");
  need(edge_tolerance_m > 0.0 && edge_tolerance_m < min_tread_m,
       "edge_tolerance_m must lie between 0 and min_tread_m");
  need(max_turn_deg > 0.0 && max_turn_deg < 45.0, "max_turn_deg must lie between 0 and 45");
  need(max_tread_slope_deg > 0.0 && max_tread_slope_deg < 30.0,
       "max_tread_slope_deg must lie between 0 and 30");
  return problems;
}

std::vector<FoundStaircase> StaircaseFinder::Find(const std::vector<SurfacePtr>& surfaces,
                                                  const std::vector<FlightModel>& known, bool compete) const {
  const FlightSearch search(config_, surfaces);
  std::vector<Candidate> candidates = search.Candidates();
  std::vector<FoundStaircase> found;
  const auto take = [&](FoundStaircase&& staircase) {
    std::set<int> used;
    for (const StepMember& member : staircase.members) used.insert(member.surface);
    std::erase_if(candidates, [&](const Candidate& c) { return used.contains(c.surface); });
    found.push_back(std::move(staircase));
  };

  constexpr int kMaxFlights = 16;
  if (!compete) {
    for (const FlightModel& model : known) {
      std::optional<Flight> flight = search.Follow(model, candidates);
      std::optional<FoundStaircase> staircase =
          flight ? search.Complete(std::move(*flight), true) : std::nullopt;
      if (staircase) take(std::move(*staircase));
    }
  }
  while (candidates.size() >= 2 && found.size() < kMaxFlights) {
    std::optional<FoundStaircase> best;
    double best_score = 0.0;
    const auto consider = [&](std::optional<Flight> flight, bool is_known) {
      // A flight that was there before stays unless another explains clearly more.
      const double bonus = is_known ? 1.0 : 0.0;
      if (!flight || flight->score + bonus <= best_score) return;
      const double score = flight->score + bonus;
      std::optional<FoundStaircase> staircase = search.Complete(std::move(*flight), is_known);
      if (!staircase) return;
      best = std::move(staircase);
      best_score = score;
    };
    for (const FlightModel& model : known) consider(search.Follow(model, candidates), true);
    for (const FlightModel& frame : search.StraightFrames(candidates))
      consider(search.BestStride(frame, search.Measure(candidates, frame)), false);
    for (const FlightModel& frame : search.SpiralFrames(candidates))
      consider(search.BestStride(frame, search.Measure(candidates, frame)), false);
    if (!best) break;
    take(std::move(*best));
  }
  return found;
}

}  // namespace terrace
