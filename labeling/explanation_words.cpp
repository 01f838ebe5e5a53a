// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/explanation_words.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/angles.h"
#include "core/print.h"

namespace terrace {
namespace {

constexpr double kMmPerM = 1000.0;

long long Shown(std::int64_t id) { return static_cast<long long>(id); }

/// How far a slope is from a limit, in its standard deviations.
std::string SigmasTo(double limit_deg, const RegionExplanation& region) {
  const double sigmas =
      std::abs(Radians(limit_deg) - region.slope_rad) / std::max(1e-6, region.slope_sigma_rad);
  return sigmas < 100.0 ? Printed("%.1f standard deviations away", sigmas)
                        : "more than 100 standard deviations away";
}

std::string Numbers(const RegionExplanation& r) {
  std::string text = Printed("Slope %.1f +- %.1f deg", Degrees(r.slope_rad), Degrees(r.slope_sigma_rad));
  if (r.rule == LabelRule::kInferredStep)
    return text +
           Printed(", place known to %.0f mm, %.2f m2, never seen.", kMmPerM * r.offset_sigma_m, r.area_m2);
  Print(&text, ", points %.1f mm rms off the plane (noise of single ones %.1f mm), %.2f m2",
        kMmPerM * r.rms_m, kMmPerM * r.noise_m, r.area_m2);
  if (r.largest_square_m) Print(&text, ", holds a square of %.2f m", *r.largest_square_m);
  Print(&text, ", %d observations", r.num_observations);
  if (r.nearest_view_m) Print(&text, ", from %.1f m at nearest", *r.nearest_view_m);
  return text + ".";
}

std::string Neighbors(const RegionExplanation& r) {
  if (r.neighbors.empty()) return "";
  constexpr std::size_t kMaxTold = 8;
  std::string text = "Beside it: ";
  for (std::size_t i = 0; i < std::min(kMaxTold, r.neighbors.size()); ++i) {
    const NeighborRegion& n = r.neighbors[i];
    Print(&text, "%s%lld (%s%.2f m)", i > 0 ? ", " : "", Shown(n.id), n.joins ? "joins, " : "a step of ",
          std::abs(n.step_m) < 0.005 ? 0.0 : n.step_m);
  }
  if (r.neighbors.size() > kMaxTold) Print(&text, " and %zu more", r.neighbors.size() - kMaxTold);
  return text + ".";
}

void AddSentence(std::string* text, const std::string& sentence) {
  if (!sentence.empty()) *text += " " + sentence;
}

/// "1 to 4, 6": indices of steps.
std::string Ranges(const std::vector<int>& ascending) {
  if (ascending.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < ascending.size();) {
    std::size_t last = i;
    while (last + 1 < ascending.size() && ascending[last + 1] == ascending[last] + 1) ++last;
    Print(&text, last > i ? "%s%d to %d" : "%s%d", i > 0 ? ", " : "", ascending[i], ascending[last]);
    i = last + 1;
  }
  return text;
}

std::string EndInWords(const char* name, const std::optional<std::int64_t>& region) {
  return region ? Printed("%s is region %lld", name, Shown(*region)) : Printed("%s was not seen", name);
}

}  // namespace

std::string ExplanationWords::Reason(const RegionExplanation& r) const {
  const double height_m = r.height_m.value_or(0.0);
  const long long by = Shown(r.decided_by.value_or(0));
  switch (r.rule) {
    case LabelRule::kNotLookedAt:
      return "it was a step of a staircase that is told no more, and was not looked at since";
    case LabelRule::kStep:
    case LabelRule::kInferredStep:
      return Printed("%s %d of staircase %lld, %s", r.label == TerrainLabel::kStairRiser ? "riser" : "tread",
                     r.step_index.value_or(0), Shown(r.staircase.value_or(0)),
                     r.rule == LabelRule::kStep ? "whose law it obeys" : "whose law demands it");
    case LabelRule::kReachableGround:
      return "level, large enough to walk on, and reachable from where the robot stands or stood";
    case LabelRule::kContinuesGround:
      return Printed("level, and goes on where the reachable ground of region %lld ends", by);
    case LabelRule::kReachableSlope:
      return "inclined, a plane, large enough to walk on, and reachable";
    case LabelRule::kStandsOnGround:
      return Printed("lies %.2f m above lower ground beside it, and is not large and reachable", height_m);
    case LabelRule::kOutOfReach:
      return "level and not reachable, and no top of what stands on the ground";
    case LabelRule::kHighFace:
      return Printed("upright, and rises %.2f m above the ground at its foot", height_m);
    case LabelRule::kFaceOutOfView:
      return Printed("upright, and goes on where the view ended, %.2f m above its foot", height_m);
    case LabelRule::kContinuesWall:
      return Printed("upright, in the plane of the wall %lld and near it", by);
    case LabelRule::kFaceWithTop:
      return Printed("upright, %.2f m high, with something level on its upper edge", height_m);
    case LabelRule::kFaceEnds:
      return Printed("upright, %.2f m high, and what lies above it was seen", height_m);
    case LabelRule::kSteepOnGround:
      return "too steep to walk on, and stands on the ground";
    case LabelRule::kTooSmall:
      return "too small to be decided";
    case LabelRule::kTopNotSeen:
      return Printed("upright, %.2f m high as far as seen, its top was not seen", height_m);
    case LabelRule::kSlopeNotResolved:
      return "inclined, and seen too badly to exclude steps";
    case LabelRule::kSlopeNotPlane:
      return "inclined, and departs from its plane by more than noise does";
    case LabelRule::kSlopeJustSeen:
      return "inclined, seen as a ramp for too few frames";
    case LabelRule::kSlopeOutOfReach:
      return "inclined, large, and not reachable";
    case LabelRule::kSlopeTooSmall:
      return "inclined, and too small to walk on";
    case LabelRule::kSlopeNotKnown:
      return "large or beside large ground, and how it leans is not known";
    case LabelRule::kSteepFootNotKnown:
      return "too steep to walk on, and nothing is known of its foot";
    case LabelRule::kTooSmallToWalkOn:
      return "level and reachable, and too small to walk on";
    case LabelRule::kFacesDown:
      return "it faces down";
  }
  return "";
}

std::string ExplanationWords::OtherwiseSupport(const RegionExplanation& r) const {
  switch (r.rule) {
    case LabelRule::kStep:
      return Printed("Without its staircase it would be %s.", Name(r.by_itself.value_or(r.label)));
    case LabelRule::kReachableGround:
    case LabelRule::kContinuesGround:
      return Printed(
          "It would be a ramp from a slope of %.1f deg on (%s), and level or obstacle if it could not be "
          "reached.",
          robot_.max_walkway_slope_deg, SigmasTo(robot_.max_walkway_slope_deg, r).c_str());
    case LabelRule::kReachableSlope:
      return Printed(
          "It would be walkway up to a slope of %.1f deg (%s), too steep beyond %.1f deg (%s), and unknown "
          "if "
          "steps could hide in it: those of %.0f mm would show, stairs have %.0f mm at least.",
          robot_.max_walkway_slope_deg, SigmasTo(robot_.max_walkway_slope_deg, r).c_str(),
          robot_.max_ramp_slope_deg, SigmasTo(robot_.max_ramp_slope_deg, r).c_str(),
          kMmPerM * r.lowest_step_m.value_or(0.0), kMmPerM * stairs_.min_riser_m);
    case LabelRule::kStandsOnGround:
    case LabelRule::kTooSmallToWalkOn:
      return Printed(
          "It would be walkway or ramp if it held a square of %.2f m, alone or with what joins it (%s), and "
          "could be "
          "reached (%s by steps of up to %.2f m).",
          config_.min_walkway_edge_m, r.large.value_or(false) ? "it does" : "it does not",
          r.reachable.value_or(false) ? "it can" : "it cannot", robot_.max_step_height_m);
    case LabelRule::kOutOfReach:
    case LabelRule::kSlopeOutOfReach:
      return Printed(
          "It would be %s if the robot could come to it by steps of up to %.2f m and gaps of up to %.2f m.",
          r.rule == LabelRule::kOutOfReach ? "walkway" : "ramp", robot_.max_step_height_m,
          robot_.max_step_reach_m);
    default:
      return "";
  }
}

std::string ExplanationWords::OtherwiseFace(const RegionExplanation& r) const {
  switch (r.rule) {
    case LabelRule::kHighFace:
    case LabelRule::kFaceOutOfView:
      return Printed("It would be an obstacle if it rose less than %.2f m%s.", config_.min_wall_height_m,
                     r.rule == LabelRule::kFaceOutOfView ? " and its end had been seen" : "");
    case LabelRule::kContinuesWall:
      return Printed("By itself it would be an obstacle or undecided: it rises %.2f m.",
                     r.height_m.value_or(0.0));
    case LabelRule::kFaceWithTop:
    case LabelRule::kFaceEnds:
      return Printed(
          "It would be a wall if it rose %.2f m or more, and a riser if others of one law were seen with it.",
          config_.min_wall_height_m);
    case LabelRule::kSteepOnGround:
      return Printed("It would be a ramp up to a slope of %.1f deg (%s), and upright from %.1f deg on (%s).",
                     robot_.max_ramp_slope_deg, SigmasTo(robot_.max_ramp_slope_deg, r).c_str(),
                     config_.min_upright_deg, SigmasTo(config_.min_upright_deg, r).c_str());
    default:
      return "";
  }
}

std::string ExplanationWords::OtherwiseUndecided(const RegionExplanation& r) const {
  switch (r.rule) {
    case LabelRule::kTooSmall:
      return Printed("It is decided from %.2f m2 on.", config_.min_decided_area_m2);
    case LabelRule::kTopNotSeen:
      return Printed("It will be wall or obstacle once its top is in view from within %.1f m.",
                     config_.max_resolving_distance_m);
    case LabelRule::kSlopeNotResolved:
      return Printed(
          "It may be a ramp or stairs: steps lower than %.0f mm would not show, and stairs have %.0f mm at "
          "least.",
          kMmPerM * r.lowest_step_m.value_or(0.0), kMmPerM * stairs_.min_riser_m);
    case LabelRule::kSlopeNotPlane:
      return "It may be stairs or uneven ground.";
    case LabelRule::kSlopeJustSeen:
      return Printed("It becomes a ramp after %d such frames in a row.", config_.frames_to_change_label);
    case LabelRule::kSlopeTooSmall:
      return Printed("A ramp holds a square of %.2f m.", config_.min_walkway_edge_m);
    case LabelRule::kSlopeNotKnown:
      return Printed(
          "A walkway leans by no more than %.0f deg, with two standard deviations that are no wider.",
          robot_.max_walkway_slope_deg);
    default:
      return "";
  }
}

std::string ExplanationWords::Of(const RegionExplanation& r) const {
  std::string text = Printed("region %lld: %s (confidence %.2f): %s.", Shown(r.id), Name(r.label),
                             r.confidence, Reason(r).c_str());
  AddSentence(&text, Numbers(r));
  AddSentence(&text, Neighbors(r));
  AddSentence(&text, OtherwiseSupport(r));
  AddSentence(&text, OtherwiseFace(r));
  AddSentence(&text, OtherwiseUndecided(r));
  if (r.next_label)
    AddSentence(&text, Printed("The last %d %s found it to be %s; %d in a row change the label.", r.num_next,
                               r.num_next == 1 ? "frame" : "frames", Name(*r.next_label),
                               config_.frames_to_change_label));
  return text;
}

std::string ExplanationWords::Of(const StaircaseExplanation& s) const {
  std::string text = Printed(
      "staircase %lld (confidence %.2f): %d risers of %.3f +- %.3f m, treads of %.3f +- %.3f m, pitch %.0f "
      "deg.",
      Shown(s.id), s.confidence, s.num_risers, s.riser_m, s.riser_sigma_m, s.tread_m, s.tread_sigma_m,
      Degrees(s.pitch_rad));
  AddSentence(&text, Printed("Seen of it are risers %s and treads %s; %s; %s.", Ranges(s.risers_seen).c_str(),
                             Ranges(s.treads_seen).c_str(),
                             EndInWords("the floor at its foot", s.foot_region).c_str(),
                             EndInWords("the landing at its head", s.head_region).c_str()));
  AddSentence(
      &text,
      Printed("When it was last found, %d of %d steps that could be seen obeyed one law, with heights "
              "%.1f mm rms about it; faces %s from step to step; sides %s; it was seen %s.",
              s.num_seen, s.num_to_see, kMmPerM * s.height_rms_m, s.faces_tile ? "reach" : "do not reach",
              s.sides_agree ? "agree" : "do not agree", s.seen_sharply ? "sharply" : "through noise"));
  AddSentence(
      &text,
      Printed("It would be clutter or undecided below a confidence of %.2f, a ramp or a row of kerbs below a "
              "pitch of %.0f deg, a ladder above %.0f deg.",
              stairs_.min_confidence, stairs_.min_pitch_deg, stairs_.max_pitch_deg));
  AddSentence(&text, s.riser_m <= robot_.max_step_height_m
                         ? Printed("The robot climbs steps of up to %.2f m.", robot_.max_step_height_m)
                         : Printed("Its steps are higher than the %.2f m that the robot climbs.",
                                   robot_.max_step_height_m));
  return text;
}

}  // namespace terrace
