// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/loaded_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/map_difference.h"
#include "core/print.h"
#include "daemon/map_alignment.h"
#include "daemon/terrain_publisher.h"

namespace terrace {
namespace {

constexpr const char* kNobodySays = "nobody has said where the robot is in it";
constexpr const char* kLost = "tracking was lost and another world has begun: say again where the robot is";

/// What to add to a sentence.
std::string WhyNotRecognised(const PlaceFinder& finder) {
  if (finder.views().empty()) return ", and it was saved without views to recognise it by";
  return ", and " + finder.reason();
}

bool SaysSomething(const MapDifference& d) {
  return !d.added.empty() || !d.revised.empty() || !d.removed.empty() || !d.changed_staircases.empty() ||
         !d.removed_staircases.empty();
}

}  // namespace

LoadedMap::LoadedMap(const StereoCamera& camera, const std::optional<Eigen::Isometry3d>& T_body_left)
    : T_body_left_(T_body_left.value_or(LevelBody())), finder_(camera) {}

void LoadedMap::Load(SavedMap saved, std::string file, const std::optional<BodyInMap>& body) {
  const std::lock_guard lock(mutex_);
  TakeOutOfTheWorld();
  loaded_ = std::move(saved.map);
  finder_.Seek(std::move(saved.views));
  file_ = std::move(file);
  body_ = body;
  reason_ = body ? "no pose to put it by has come yet" : kNobodySays + WhyNotRecognised(finder_);
}

std::optional<MapTransform> LoadedMap::transform() const {
  const std::lock_guard lock(mutex_);
  if (!loaded_) return std::nullopt;
  MapTransform transform;
  transform.t = t_;
  transform.file = file_;
  transform.reason = reason_;
  if (!in_world_) return transform;
  transform.map_id = joint_->map_id;
  transform.placing = confirmed_    ? MapPlacing::kConfirmed
                      : recognised_ ? MapPlacing::kRecognised
                                    : MapPlacing::kGiven;
  transform.T_map_world = in_world_->place.T_map_world;
  transform.covariance = in_world_->place.covariance;
  return transform;
}

TerrainMapPtr LoadedMap::unplaced() const {
  const std::lock_guard lock(mutex_);
  return in_world_ ? nullptr : loaded_;
}

std::optional<std::int64_t> LoadedMap::OwnId(std::int64_t id) const {
  const std::lock_guard lock(mutex_);
  if (!in_world_) return id;
  if (id <= in_world_->add_to_own_ids) return std::nullopt;
  return id - in_world_->add_to_own_ids;
}

Explanations LoadedMap::InJointIds(Explanations own) const {
  const std::lock_guard lock(mutex_);
  if (!in_world_) return own;
  const std::int64_t add = in_world_->add_to_own_ids;
  const std::string note =
      Printed(" Numbers in this text are the mapper's own: the map's are greater by %lld.",
              static_cast<long long>(add));
  for (RegionExplanation& region : own.regions) {
    region.id += add;
    region.text += note;
  }
  for (StaircaseExplanation& staircase : own.staircases) {
    staircase.id += add;
    staircase.text += note;
  }
  return own;
}

std::vector<PlaceView> LoadedMap::ViewsInWorld() const {
  const std::lock_guard lock(mutex_);
  if (!in_world_) return {};
  std::vector<PlaceView> views = finder_.views();
  const Eigen::Isometry3d T_world_map = in_world_->place.T_map_world.inverse();
  for (PlaceView& view : views) view.T_world_left = T_world_map * view.T_world_left;
  return views;
}

MapChange LoadedMap::Join(const MapChange& own, const PoseEstimate& pose, const StereoFrame* frame) {
  const std::lock_guard lock(mutex_);
  t_ = pose.t_capture;
  FollowTheWorld(*own.map);
  if (loaded_ && body_ && pose.trusted) {
    const Eigen::Isometry3d T_world_body = pose.T_world_left * T_body_left_.inverse();
    recognised_ = false;
    PutIntoWorld(PlaceOf(*body_, T_world_body, own.map->gravity, loaded_->gravity), *own.map, pose,
                 "put where somebody said");
  } else if (loaded_ && !in_world_ && pose.trusted && frame) {
    LookForThePlace(*own.map, pose, *frame);
  } else if (in_world_ && own.map != own_) {
    TakeAwayWhatIsSeen(*own.map, own.before == own_ ? &own : nullptr);
    if (pose.trusted) CompareWithWhatIsSeen(*own.map, pose);
  }
  const bool same = own.map == own_ && joint_ && joint_->map_id == own.map->map_id + more_map_ids_;
  own_ = own.map;
  if (more_map_ids_ == 0) return own;

  MapChange change;
  change.map_cells = own.map_cells;
  change.map_bytes = own.map_bytes;
  change.before = joint_;
  if (!same) {
    const TerrainMapPtr before = std::exchange(joint_, Joint(*own.map));
    if (before && before->map_id == joint_->map_id) {
      static_cast<MapDifference&>(change) = DifferenceBetween(*before, *joint_);
    } else {
      change.before = nullptr;
    }
  }
  change.map = joint_;
  return change;
}

/// Another world has nothing to do with the place in the old one, and a new map in the same world was asked
/// for.
void LoadedMap::FollowTheWorld(const TerrainMap& own) {
  if (!own_ || own.map_id == own_->map_id) return;
  in_world_.reset();
  if (own.epoch == own_->epoch) {
    loaded_.reset();
    finder_.Seek({});
    body_.reset();
  } else {
    finder_.Seek(finder_.views());
    reason_ = kLost + WhyNotRecognised(finder_);
    if (loaded_) spdlog::warn("{}: {}", file_, reason_);
  }
}

void LoadedMap::LookForThePlace(const TerrainMap& own, const PoseEstimate& pose, const StereoFrame& frame) {
  if (finder_.views().empty()) return;
  const auto camera = finder_.Look(frame, pose, own.gravity, loaded_->gravity);
  if (!camera) {
    reason_ = kNobodySays + WhyNotRecognised(finder_);
    return;
  }
  recognised_ = true;
  PutIntoWorld(PlaceOf(*camera, pose.T_world_left), own, pose,
               Printed("recognised by %d corners of its views", camera->num_corners));
}

void LoadedMap::PutIntoWorld(const MapPlace& place, const TerrainMap& own, const PoseEstimate& pose,
                             const std::string& how) {
  prior_ = place;
  body_.reset();
  confirmed_ = false;
  num_frames_ = 0;
  reason_ = how + "; what is seen has not confirmed it yet";
  PutAt(prior_, own, pose.t_capture);
  spdlog::info("{}: {}", file_, reason_);
}

void LoadedMap::TakeOutOfTheWorld() {
  if (in_world_) ++more_map_ids_;
  in_world_.reset();
}

void LoadedMap::PutAt(const MapPlace& place, const TerrainMap& own, Timestamp t) {
  std::vector<TerrainRegion> regions;
  for (const auto& region : loaded_->regions) {
    regions.push_back(Placed(*region, place));
    // A file from a clock that was ahead makes nothing new.
    regions.back().last_seen = std::min(regions.back().last_seen, t);
    regions.back().first_seen = std::min(regions.back().first_seen, t);
  }
  std::vector<Staircase> staircases;
  for (const Staircase& staircase : loaded_->staircases) {
    staircases.push_back(Placed(staircase, place));
    staircases.back().last_seen = std::min(staircases.back().last_seen, t);
  }
  LoadedRegions in_world(regions);
  std::int64_t add = in_world.first_free_id();
  if (!staircases.empty()) add = std::max(add, staircases.back().id);
  in_world_.emplace(InWorld{std::move(in_world), std::move(staircases), place, add, {}});
  ++more_map_ids_;
  TakeAwayWhatIsSeen(own, nullptr);
}

/// Now and then: what is seen may confirm the place, and make it exact.
void LoadedMap::CompareWithWhatIsSeen(const TerrainMap& own, const PoseEstimate& pose) {
  constexpr int kFramesUntilConfirmed = 15, kFramesOnceConfirmed = 150;
  if (++num_frames_ < (confirmed_ ? kFramesOnceConfirmed : kFramesUntilConfirmed)) return;
  num_frames_ = 0;
  std::vector<TerrainRegion> regions;
  for (const auto& region : loaded_->regions) regions.push_back(*region);
  const Eigen::Vector3d body_world = (pose.T_world_left * T_body_left_.inverse()).translation();
  const MapAlignment alignment = Align(regions, prior_, own, body_world);
  const bool was_confirmed = std::exchange(confirmed_, alignment.confirmed);
  reason_ = alignment.reason;
  if (was_confirmed && !confirmed_)
    spdlog::warn("{}: where it lies is no longer confirmed: {}", file_, reason_);
  if (!confirmed_) {
    // Views that look alike are no proof against surfaces.
    if (recognised_ && alignment.differs_m2 > alignment.agrees_m2) {
      TakeOutOfTheWorld();
      finder_.Seek(finder_.views());
      reason_ = "it was recognised where what is seen contradicts it, and is looked for again";
      spdlog::warn("{}: {}", file_, reason_);
    }
    return;
  }
  // From here on the world may drift away by as much as somebody may have been wrong.
  prior_.T_map_world = alignment.place.T_map_world;
  constexpr double kWorthMoving_m = 0.02, kWorthMoving_rad = 0.5 * M_PI / 180.0;
  const Eigen::Isometry3d moved = in_world_->place.T_map_world.inverse() * alignment.place.T_map_world;
  const bool far = (moved * body_world - body_world).norm() > kWorthMoving_m ||
                   Eigen::AngleAxisd(moved.linear()).angle() > kWorthMoving_rad;
  if (!was_confirmed || far) {
    spdlog::info("{}: what is seen confirms where it lies, {:.3f} m and {:.2f} deg from where it was put",
                 file_, (moved * body_world - body_world).norm(),
                 Eigen::AngleAxisd(moved.linear()).angle() * 180.0 / M_PI);
    PutAt(alignment.place, own, pose.t_capture);
  }
}

void LoadedMap::TakeAwayWhatIsSeen(const TerrainMap& own, const MapDifference* changed) {
  for (const auto& region : own.regions) {
    const auto is_in = [&](const std::vector<std::int64_t>& ids) {
      return std::binary_search(ids.begin(), ids.end(), region->id);
    };
    if (changed && !is_in(changed->added) && !is_in(changed->revised)) continue;
    if (IsDecided(*region)) in_world_->regions.TakeAway(*region);
  }
}

std::vector<Staircase> LoadedMap::OwnStaircases(const TerrainMap& own) const {
  std::vector<Staircase> staircases = own.staircases;
  for (Staircase& staircase : staircases) staircase.id += in_world_->add_to_own_ids;
  return staircases;
}

/// The own map under another map_id, with what was loaded where it lies in the world.
TerrainMapPtr LoadedMap::Joint(const TerrainMap& own) {
  auto map = std::make_shared<TerrainMap>(own);
  map->map_id += more_map_ids_;
  if (in_world_) {
    JoinedStaircases joined = terrace::Join(in_world_->staircases, OwnStaircases(own));
    std::map<std::int64_t, Copy> copies;
    map->regions.clear();
    const auto add = [&](const std::shared_ptr<const TerrainRegion>& source, std::int64_t add_to_id) {
      Copy copy = CopyOf(source, add_to_id, joined, in_world_->copies);
      map->regions.push_back(copy.region);
      copies.emplace_hint(copies.end(), copy.region->id, std::move(copy));
    };
    for (const auto& region : in_world_->regions.regions()) add(region, 0);
    for (const auto& region : own.regions) {
      // What is not decided yet, or only inferred, is not put beside what is known.
      if (!IsDecided(*region) && in_world_->regions.Shows(*region)) continue;
      add(region, in_world_->add_to_own_ids);
    }
    in_world_->copies = std::move(copies);
    std::map<std::int64_t, std::vector<std::int64_t>> regions_of;
    for (const auto& region : map->regions)
      if (region->staircase_id) regions_of[*region->staircase_id].push_back(region->id);
    for (Staircase& staircase : joined.staircases) staircase.region_ids = regions_of[staircase.id];
    std::erase_if(joined.staircases, [](const Staircase& s) { return s.region_ids.empty(); });
    map->staircases = std::move(joined.staircases);
  }
  map->seq += more_seqs_;
  const bool goes_on = joint_ && joint_->map_id == map->map_id;
  if (goes_on && map->seq == joint_->seq && SaysSomething(DifferenceBetween(*joint_, *map))) {
    ++more_seqs_;
    ++map->seq;
  }
  return map;
}

LoadedMap::Copy LoadedMap::CopyOf(const std::shared_ptr<const TerrainRegion>& source, std::int64_t add_to_id,
                                  const JoinedStaircases& joined,
                                  const std::map<std::int64_t, Copy>& before) {
  Copy copy{source, std::nullopt, 0, nullptr};
  if (source->staircase_id) {
    const std::int64_t staircase_id = *source->staircase_id + add_to_id;
    const auto moved = joined.places.find(staircase_id);
    copy.place = moved == joined.places.end() ? JoinedStaircases::Place{staircase_id, 0} : moved->second;
  }
  if (const auto found = before.find(source->id + add_to_id); found != before.end()) {
    const Copy& last = found->second;
    if (last.source == source && last.place == copy.place) return last;
    copy.more_revisions = last.more_revisions + (last.place == copy.place ? 0 : 1);
  }
  auto region = std::make_shared<TerrainRegion>(*source);
  region->id += add_to_id;
  region->revision += copy.more_revisions;
  if (copy.place) {
    region->staircase_id = copy.place->staircase_id;
    if (region->step_index) *region->step_index += copy.place->add_to_step;
  }
  copy.region = std::move(region);
  return copy;
}

}  // namespace terrace
