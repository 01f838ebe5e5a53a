// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/staircase_tracker.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace terrace {
namespace {

std::vector<StepPlace> PlacesOf(const FoundStaircase& found, const std::vector<RegionShapePtr>& shapes) {
  std::vector<StepPlace> places;
  for (const StepMember& m : found.members) places.push_back({shapes[m.shape]->id(), m.riser, m.step_index});
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
  s.tread_m = m.run_m;
  s.tread_sigma_m = tracked.found.run_sigma_m;
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
  s.pitch_rad = std::atan2(m.rise_m, m.run_m);
  s.confidence = tracked.found.confidence;
  for (const StepPlace& place : tracked.places) s.region_ids.push_back(place.region);
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

}  // namespace

std::vector<FlightModel> StaircaseTracker::models() const {
  std::vector<FlightModel> models;
  for (const Track& track : tracks_)
    if (track.told) models.push_back(track.staircase.found.model);
  return models;
}

void StaircaseTracker::Update(const std::vector<FoundStaircase>& found,
                              const std::vector<RegionShapePtr>& shapes,
                              const Eigen::Matrix3d& R_level_world) {
  std::vector<bool> taken(found.size(), false);
  std::set<PolygonId> used;
  const std::size_t num_old = tracks_.size();
  for (std::size_t t = 0; t < num_old; ++t) {
    Track& track = tracks_[t];
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
      continue;
    }
    taken[best] = true;
    track.num_missed = 0;
    ++track.num_found;
    track.staircase.found = found[best];
  }
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (taken[f]) continue;
    Track track;
    track.staircase.found = found[f];
    track.num_found = 1;
    tracks_.push_back(track);
  }

  const auto present = [&](PolygonId id) {
    const auto it =
        std::lower_bound(shapes.begin(), shapes.end(), id,
                         [](const RegionShapePtr& s, PolygonId wanted) { return s->id() < wanted; });
    return it != shapes.end() && (*it)->id() == id;
  };
  for (Track& track : tracks_) {
    TrackedStaircase& s = track.staircase;
    if (track.num_missed == 0) {
      s.places = PlacesOf(s.found, shapes);
      s.foot_region = s.found.foot_shape ? shapes[*s.found.foot_shape]->id() : 0;
      s.head_region = s.found.head_shape ? shapes[*s.found.head_shape]->id() : 0;
      for (const StepPlace& place : s.places) used.insert(place.region);
    }
  }
  for (Track& track : tracks_) {
    if (track.num_missed == 0) continue;
    std::erase_if(track.staircase.places, [&](const StepPlace& place) {
      return !present(place.region) || !used.insert(place.region).second;
    });
  }
  std::erase_if(tracks_, [&](const Track& track) {
    return track.staircase.places.empty() || track.num_missed > (track.told ? num_frames_ : 0);
  });

  confirmed_.clear();
  for (Track& track : tracks_) {
    if (!track.told && track.num_found < num_frames_) continue;
    TrackedStaircase& s = track.staircase;
    if (!track.told) s.id = ++last_id_;
    Staircase now = Publish(s, R_level_world);
    if (!track.told || !PracticallyEqual(s.published, now)) s.published = now;
    track.told = true;
    for (const StepPlace& place : s.places) {
      const auto it = std::lower_bound(shapes.begin(), shapes.end(), place.region,
                                       [](const RegionShapePtr& a, PolygonId id) { return a->id() < id; });
      s.published.last_seen = std::max(s.published.last_seen, (*it)->polygon->last_seen);
    }
    confirmed_.push_back(s);
  }
  std::sort(confirmed_.begin(), confirmed_.end(),
            [](const TrackedStaircase& a, const TrackedStaircase& b) { return a.id < b.id; });
}

}  // namespace terrace
