// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_tracker.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace terrace {
namespace {

std::vector<StepPlace> PlacesOf(const FoundStaircase& found, const std::vector<RegionShapePtr>& shapes) {
  std::vector<StepPlace> places;
  for (const StepMember& m : found.members)
    places.push_back({shapes[m.shape]->id(), m.riser, m.step_index, m.only_evidence});
  return places;  // shapes ascend by id, and so do members
}

/// How well a flight that was just found continues a tracked one; 0: it is another.
int Likeness(const TrackedStaircase& tracked, const FoundStaircase& found,
             const std::vector<StepPlace>& places) {
  int shared = 0;
  for (const StepPlace& place : places)
    shared += std::any_of(tracked.places.begin(), tracked.places.end(),
                          [&](const StepPlace& p) { return p.region == place.region; });
  if (shared > 0) return 1 + shared;
  const FlightModel& a = tracked.found.model;
  const FlightModel& b = found.model;
  constexpr double kSameFoot = 0.5;
  constexpr double kSameDirection = 0.87;  // 30 deg
  const bool same =
      a.spiral == b.spiral && a.UpAt(1.0).dot(b.UpAt(1.0)) > kSameDirection &&
      (a.EdgePoint(1.0, a.lateral.middle()) - b.EdgePoint(1.0, b.lateral.middle())).norm() < kSameFoot &&
      std::abs(a.foot_z - b.foot_z) < kSameFoot;
  return same ? 1 : 0;
}

Staircase Publish(const TrackedStaircase& tracked, const Eigen::Matrix3d& R_level_world) {
  const FlightModel& m = tracked.found.model;
  const Eigen::Matrix3d R_world_level = R_level_world.transpose();
  Staircase s;
  s.id = tracked.id;
  s.num_risers = tracked.found.num_risers;
  s.num_treads = tracked.found.num_treads;
  s.riser_m = m.rise_m;
  s.riser_sigma_m = tracked.found.rise_sigma_m;
  // Of a spiral the law holds the run at some radius, and treads are told at the middle of the width.
  const double at_middle = m.spiral ? m.lateral.middle() / m.radius_m : 1.0;
  s.tread_m = at_middle * m.run_m;
  s.tread_sigma_m = at_middle * tracked.found.run_sigma_m;
  s.width_m = m.lateral.length();
  // Of a spiral lateral is the distance from the axis, and the axis lies left when it turns left.
  const bool low_is_left = m.spiral && m.turn_sign > 0.0;
  const double left = low_is_left ? m.lateral.low : m.lateral.high;
  const double right = low_is_left ? m.lateral.high : m.lateral.low;
  const auto point = [&](double k, double lateral, double z) {
    const Eigen::Vector2d p = m.EdgePoint(k, lateral);
    return Eigen::Vector3d(R_world_level * Eigen::Vector3d(p.x(), p.y(), z));
  };
  const double n = s.num_risers;
  s.foot_edge_world = {point(1.0, left, m.foot_z), point(1.0, right, m.foot_z)};
  s.head_edge_world = {point(n, left, m.foot_z + n * m.rise_m), point(n, right, m.foot_z + n * m.rise_m)};
  Eigen::Vector3d up = R_world_level * Eigen::Vector3d(m.UpAt(1.0).x(), m.UpAt(1.0).y(), 0.0);
  up.z() = 0.0;
  s.direction_up_world = up.normalized();
  s.turn_per_step_rad = m.spiral ? m.turn_sign * m.run_m / m.radius_m : 0.0;
  s.pitch_rad = std::atan2(s.riser_m, s.tread_m);
  s.confidence = tracked.found.confidence;
  for (const StepPlace& place : tracked.places)
    if (!place.only_evidence) s.region_ids.push_back(place.region);
  return s;
}

/// True when nobody would step otherwise for the difference.
bool PracticallyEqual(const Staircase& a, const Staircase& b) {
  constexpr double kHeight = 0.001, kDepth = 0.003, kWidth = 0.02, kEdge = 0.01;
  constexpr double kTurn = 0.01, kConfidence = 0.03;
  return a.num_risers == b.num_risers && a.num_treads == b.num_treads && a.region_ids == b.region_ids &&
         std::abs(a.riser_m - b.riser_m) < kHeight && std::abs(a.tread_m - b.tread_m) < kDepth &&
         std::abs(a.width_m - b.width_m) < kWidth && (a.base_world() - b.base_world()).norm() < kEdge &&
         (a.direction_up_world - b.direction_up_world).norm() < kTurn &&
         std::abs(a.turn_per_step_rad - b.turn_per_step_rad) < kTurn &&
         std::abs(a.confidence - b.confidence) < kConfidence;
}

/// In how many frames in a row a new law must be found before it is believed: 0 when both may be right.
/// What a single frame says against all that were before it may be wrong, the more so when it knows less.
int FramesToBelieve(const FoundStaircase& told, const FoundStaircase& now, int num_frames, int patience) {
  constexpr double kBetter = 0.8, kWorse = 2.0;  // of two standard deviations
  if (told.model.spiral != now.model.spiral) return num_frames;
  const auto frames = [&](double a, double sigma_a, double b, double sigma_b) {
    if (std::abs(a - b) <= sigma_a + sigma_b) return 0;
    if (sigma_b < kBetter * sigma_a) return 1;
    return sigma_b > kWorse * sigma_a ? patience * num_frames : num_frames;
  };
  return std::max(frames(told.model.rise_m, told.rise_sigma_m, now.model.rise_m, now.rise_sigma_m),
                  frames(told.model.run_m, told.run_sigma_m, now.model.run_m, now.run_sigma_m));
}

/// How far from the foot edge what is seen of a flight begins [steps].
double StepsFromFoot(const FoundStaircase& found) {
  int lowest = found.num_risers;
  for (const StepMember& member : found.members) lowest = std::min(lowest, member.step_index);
  return lowest;
}

/// True when the law that was told is as well known as the new one, and both may be the same: then it rests.
/// Where the foot lies is known by what is seen of the steps, and the worse the farther away that is.
/// @param fresh  it was just found: then anything better counts
bool LawRests(const FoundStaircase& told, const FoundStaircase& now, bool fresh) {
  constexpr double kClearlyBetter = 0.8;
  const double better = fresh ? 1.0 : kClearlyBetter;
  const auto rests = [better](double a, double sigma_a, double b, double sigma_b) {
    return std::abs(a - b) <= sigma_a + sigma_b && sigma_b >= better * sigma_a;
  };
  const FlightModel& a = told.model;
  const FlightModel& b = now.model;
  constexpr double kSameEdge = 0.02;
  constexpr double kSameDirection = 0.998;  // 4 deg
  const double steps = std::max(StepsFromFoot(told), StepsFromFoot(now));
  const double same_z = kSameEdge + steps * (told.rise_sigma_m + now.rise_sigma_m);
  const double same_edge = kSameEdge + steps * (told.run_sigma_m + now.run_sigma_m);
  const Eigen::Vector2d shift = a.EdgePoint(1.0, a.lateral.middle()) - b.EdgePoint(1.0, b.lateral.middle());
  // Sides come into view and leave it: no step is wider for that. But of a spiral the run is told at the
  // middle of its width, and the inner side is hidden by its own steps at first.
  constexpr double kWider_m = 0.1;
  const bool wider = b.spiral && b.lateral.length() > a.lateral.length() + kWider_m;
  return a.spiral == b.spiral && !wider && rests(a.rise_m, told.rise_sigma_m, b.rise_m, now.rise_sigma_m) &&
         rests(a.run_m, told.run_sigma_m, b.run_m, now.run_sigma_m) &&
         a.UpAt(1.0).dot(b.UpAt(1.0)) > kSameDirection && std::abs(a.foot_z - b.foot_z) < same_z &&
         std::abs(shift.dot(a.UpAt(1.0))) < same_edge;
}

/// Sides go out of view when the robot comes near: a flight that was wider where it is now seen still is.
void KeepWidth(const FlightModel& told, FlightModel& now) {
  constexpr double kInPart = 0.85;
  constexpr double kSlack = 0.1;
  if (told.spiral || now.spiral || now.lateral.length() > kInPart * told.lateral.length()) return;
  const double shift = LeftOf(now.direction).dot(told.origin - now.origin);
  const Interval wide{told.lateral.low + shift, told.lateral.high + shift};
  if (now.lateral.low > wide.low - kSlack && now.lateral.high < wide.high + kSlack) now.lateral = wide;
}

/// How many steps of the told flight lie below the first one that was found now.
int StepsBelow(const FoundStaircase& told, const FoundStaircase& now) {
  return static_cast<int>(std::lround((now.model.foot_z - told.model.foot_z) / told.model.rise_m));
}

/// The same flight with its steps counted from `steps` lower.
void CountFromBelow(FoundStaircase& found, int steps) {
  FlightModel& m = found.model;
  const Eigen::Vector2d up = m.UpAt(1.0 - steps);
  if (m.spiral)
    m.direction = -m.turn_sign * LeftOf(up);
  else
    m.origin -= m.direction * (m.run_m * steps);
  m.foot_z -= steps * m.rise_m;
  for (StepMember& member : found.members) member.step_index += steps;
  found.num_risers += steps;
  found.num_treads += steps;
}

/// All that a staircase hangs on, floor and landing included.
std::vector<PolygonId> RegionsOf(const TrackedStaircase& staircase) {
  std::vector<PolygonId> regions{staircase.foot_region, staircase.head_region};
  for (const StepPlace& place : staircase.places) regions.push_back(place.region);
  std::erase(regions, PolygonId{0});
  return regions;
}

bool LookedAt(const TrackedStaircase& staircase, const ShapeTable& table) {
  // One whose regions are all gone is looked for again.
  bool any_there = false;
  for (const StepPlace& place : staircase.places) {
    if (table.IndexOf(place.region) >= 0) return true;
    any_there |= table.Find(place.region) != nullptr;
  }
  return !any_there;
}

}  // namespace

std::vector<FlightModel> StaircaseTracker::Models(const ShapeTable& table) {
  Wake(table);
  std::vector<FlightModel> models;
  for (const auto& [serial, track] : tracks_)
    if (track.told && LookedAt(track.staircase, table)) models.push_back(track.staircase.found.model);
  return models;
}

bool StaircaseTracker::contested() const {
  return std::any_of(tracks_.begin(), tracks_.end(), [](const auto& entry) {
    const Track& track = entry.second;
    const bool more = track.num_other_count > 0 && track.other_count > track.staircase.found.num_risers;
    return track.told && (track.num_other_law > 0 || more);
  });
}

void StaircaseTracker::Adopt(Track& track, FoundStaircase now) const {
  FoundStaircase& told = track.staircase.found;
  track.rests = false;
  if (!track.told) {
    told = std::move(now);
    return;
  }
  constexpr int kPatience = 8;
  const int enough = FramesToBelieve(told, now, num_frames_, kPatience);
  track.num_other_law = enough > 0 ? track.num_other_law + 1 : 0;
  if (track.num_other_law < enough) {
    track.rests = true;  // its regions as they were
    return;
  }
  track.num_other_law = 0;
  // A step that is hidden for some time is still there, and one that appears in a single frame may not be.
  const int below = StepsBelow(told, now);
  const bool fewer = below >= 0 && now.num_risers + below <= told.num_risers;
  const bool same_count =
      below == 0 && now.num_risers == told.num_risers && now.num_treads == told.num_treads;
  if (same_count) {
    track.num_other_count = 0;
  } else {
    const bool again = track.other_count == now.num_risers && track.other_below == below;
    track.num_other_count = again ? track.num_other_count + 1 : 1;
    track.other_count = now.num_risers;
    track.other_below = below;
    const bool long_enough = track.num_other_count >= (fewer ? kPatience * num_frames_ : num_frames_);
    if (!long_enough && !fewer) {
      track.rests = true;  // its regions as they were
      return;
    }
    if (long_enough) {
      track.num_other_count = 0;
      // More steps at the top do not say that those at the foot, hidden now, are gone.
      if (!fewer && below > 0) CountFromBelow(now, below);
    } else {
      if (below > 0) CountFromBelow(now, below);
      now.num_risers = told.num_risers;
      now.num_treads = told.num_treads;
      std::erase_if(now.members, [&](const StepMember& member) {
        return member.step_index > (member.riser ? now.num_risers : now.num_treads);
      });
    }
  }
  KeepWidth(told.model, now.model);
  if (LawRests(told, now, track.num_found <= 2 * num_frames_)) {
    now.model = told.model;
    now.rise_sigma_m = told.rise_sigma_m;
    now.run_sigma_m = told.run_sigma_m;
  }
  told = std::move(now);
}

void StaircaseTracker::Match(const std::vector<FoundStaircase>& found,
                             const std::vector<RegionShapePtr>& shapes) {
  std::vector<bool> taken(found.size(), false);
  for (auto& [serial, track] : tracks_) {
    if (track.away) continue;
    int most = 0;
    std::size_t best = found.size();
    for (std::size_t f = 0; f < found.size(); ++f) {
      if (taken[f]) continue;
      const int likeness = Likeness(track.staircase, found[f], PlacesOf(found[f], shapes));
      if (likeness <= most) continue;
      most = likeness;
      best = f;
    }
    if (best == found.size()) {
      ++track.num_missed;
      track.num_found = 0;
      track.doubt = 1.0;
      continue;
    }
    taken[best] = true;
    track.num_missed = 0;
    ++track.num_found;
    track.doubt *= 1.0 - found[best].confidence;
    Adopt(track, found[best]);
  }
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (taken[f]) continue;
    Track track;
    track.staircase.found = found[f];
    track.num_found = 1;
    track.doubt = 1.0 - found[f].confidence;
    tracks_.emplace(++last_serial_, std::move(track));
  }
}

/// Which regions belong to each staircase, none to two of them. What was not found keeps those that exist.
void StaircaseTracker::TakePlaces(const ShapeTable& table) {
  std::set<PolygonId> used;
  const auto keeps = [](const Track& track) { return track.away || track.rests || track.num_missed > 0; };
  for (auto& [serial, track] : tracks_) {
    if (keeps(track)) continue;
    TrackedStaircase& s = track.staircase;
    s.places = PlacesOf(s.found, table.shapes());
    s.foot_region = s.found.foot_shape ? table.shapes()[*s.found.foot_shape]->id() : 0;
    s.head_region = s.found.head_shape ? table.shapes()[*s.found.head_shape]->id() : 0;
    for (const StepPlace& place : s.places) used.insert(place.region);
  }
  for (auto& [serial, track] : tracks_) {
    if (!keeps(track)) continue;
    std::erase_if(track.staircase.places, [&](const StepPlace& place) {
      return table.Find(place.region) == nullptr || !used.insert(place.region).second;
    });
  }
}

void StaircaseTracker::Wake(const ShapeTable& table) {
  std::vector<Serial> waking;
  const auto wake = [&](PolygonId region) {
    const auto [begin, end] = asleep_by_region_.equal_range(region);
    for (auto it = begin; it != end; ++it) waking.push_back(it->second);
  };
  for (const RegionShapePtr& shape : table.shapes()) wake(shape->id());
  for (const PolygonId region : table.removed()) wake(region);
  for (const Serial serial : waking) {
    const auto sleeper = asleep_.find(serial);
    if (sleeper == asleep_.end()) continue;  // two of its regions called
    for (const PolygonId region : RegionsOf(sleeper->second.staircase)) {
      const auto [begin, end] = asleep_by_region_.equal_range(region);
      asleep_by_region_.erase(
          std::find_if(begin, end, [&](const auto& entry) { return entry.second == serial; }));
    }
    tracks_.insert(asleep_.extract(sleeper));
  }
}

void StaircaseTracker::PutToSleep(const ShapeTable& table) {
  for (auto it = tracks_.begin(); it != tracks_.end();) {
    const auto track = it++;
    const std::vector<PolygonId> regions = RegionsOf(track->second.staircase);
    const bool looked_at = std::any_of(regions.begin(), regions.end(),
                                       [&](PolygonId region) { return table.IndexOf(region) >= 0; });
    if (!track->second.away || looked_at) continue;
    for (const PolygonId region : regions) asleep_by_region_.emplace(region, track->first);
    asleep_.insert(tracks_.extract(track));
  }
}

void StaircaseTracker::ForgetGone() {
  std::erase_if(tracks_, [&](const auto& entry) {
    const Track& track = entry.second;
    const bool gone = track.staircase.places.empty() || track.num_missed > (track.told ? num_frames_ : 0);
    if (gone && track.told) {
      removed_.push_back(track.staircase.id);
      confirmed_.erase(track.staircase.id);
    }
    return gone;
  });
  std::sort(removed_.begin(), removed_.end());
}

/// Tells a staircase that has been found often enough: two frames that leave little doubt are.
void StaircaseTracker::Confirm(Track* track, const ShapeTable& table) {
  constexpr int kLeastFrames = 2;
  constexpr double kLittleDoubt = 0.02;
  // Steps that join a floor and a landing, whose heights they fit, are hardly anything else.
  constexpr double kLittleDoubtBetweenLevels = 0.06;
  const TrackedStaircase& found = track->staircase;
  const bool joins = found.foot_region != 0 && found.head_region != 0;
  const bool sure =
      track->num_found >= kLeastFrames && track->doubt <= (joins ? kLittleDoubtBetweenLevels : kLittleDoubt);
  if (!track->told && !sure && track->num_found < num_frames_) return;
  TrackedStaircase& s = track->staircase;
  if (!track->told) s.id = ++last_id_;
  Staircase now = Publish(s, table.R_level_world());
  if (!track->told || !PracticallyEqual(s.published, now)) s.published = now;
  track->told = true;
  for (const StepPlace& place : s.places)
    s.published.last_seen = std::max(s.published.last_seen, table.Find(place.region)->last_seen);
  looked_at_.push_back(&(confirmed_[s.id] = s));
}

void StaircaseTracker::Update(const std::vector<FoundStaircase>& found, const ShapeTable& table) {
  Wake(table);
  for (auto& [serial, track] : tracks_) track.away = !LookedAt(track.staircase, table);
  Match(found, table.shapes());
  TakePlaces(table);
  removed_.clear();
  looked_at_.clear();
  ForgetGone();
  for (auto& [serial, track] : tracks_) Confirm(&track, table);
  std::sort(looked_at_.begin(), looked_at_.end(),
            [](const TrackedStaircase* a, const TrackedStaircase* b) { return a->id < b->id; });
  PutToSleep(table);
}

}  // namespace terrace
