// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_follower.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "lcmtypes/codec.h"
#include "lcmtypes/safe_decode.h"

namespace terrace {
namespace {

// Far above any map; what strangers on the bus can make us keep.
constexpr std::int32_t kMaxParts = 1000;
constexpr std::size_t kMaxPending = 64;
constexpr std::size_t kMaxPendingBytes = 32u << 20;
// Packets overtake one another by a few; a state that is still missing after three newer ones is lost.
constexpr std::size_t kLostAfter = 3;
// For this many messages, what belongs to a map that was replaced is taken for late; afterwards it could be
// that the daemon went back to it.
constexpr std::int64_t kRetiredMessages = 50;

bool MakesSense(const terrain_v1_t& message) {
  const bool kind = message.kind == terrain_v1_t::SNAPSHOT ||
                    (message.kind == terrain_v1_t::DELTA && message.base_seq < message.seq);
  return kind && message.n_parts >= 1 && message.n_parts <= kMaxParts && message.part >= 0 &&
         message.part < message.n_parts;
}

}  // namespace

bool TerrainFollower::Receive(const void* data, std::size_t size) {
  std::optional<terrain_v1_t> message = SafeDecode<terrain_v1_t>(data, size);
  if (!message || !MakesSense(*message)) {
    ++num_bad_messages_;
    return false;
  }
  ++num_messages_;
  std::erase_if(retired_, [&](const auto& entry) { return num_messages_ - entry.second > kRetiredMessages; });
  if (IsOutdated(message->map_id, message->seq)) return false;
  return AddPart(std::make_shared<const terrain_v1_t>(std::move(*message)), size) && ApplyAll();
}

bool TerrainFollower::needs_snapshot() const { return !map_ || pending_.size() >= kLostAfter; }

bool TerrainFollower::IsOutdated(std::int64_t map_id, std::int64_t seq) const {
  return retired_.contains(map_id) || (map_ && map_id == map_->map_id && seq <= map_->seq);
}

/// True when the part completed a step.
bool TerrainFollower::AddPart(std::shared_ptr<const terrain_v1_t> part, std::size_t size) {
  const bool snapshot = part->kind == terrain_v1_t::SNAPSHOT;
  const auto num_parts = static_cast<std::size_t>(part->n_parts);
  auto step = std::find_if(pending_.begin(), pending_.end(), [&](const Step& s) {
    return s.map_id == part->map_id && s.seq == part->seq && s.snapshot == snapshot &&
           s.base_seq == part->base_seq && s.parts.size() == num_parts;
  });
  if (step == pending_.end()) {
    pending_.push_back({part->map_id, part->seq, part->base_seq, snapshot, {}, num_parts, 0});
    step = std::prev(pending_.end());
    step->parts.resize(num_parts);
  }
  auto& place = step->parts[static_cast<std::size_t>(part->part)];
  if (place) return false;
  place = std::move(part);
  --step->num_missing;
  step->num_bytes += size;
  pending_bytes_ += size;
  const bool complete = step->num_missing == 0;
  while (pending_.size() > kMaxPending || pending_bytes_ > kMaxPendingBytes) {
    pending_bytes_ -= pending_.front().num_bytes;
    pending_.pop_front();
  }
  return complete;
}

/// Applies one complete step after the other as long as one fits; true when any did.
bool TerrainFollower::ApplyAll() {
  bool changed = false;
  for (auto found = FindApplicable(); found != pending_.end(); found = FindApplicable()) {
    const Step step = std::move(*found);
    pending_bytes_ -= step.num_bytes;
    pending_.erase(found);
    if (!Apply(step)) {
      ++num_bad_messages_;
      continue;
    }
    changed = true;
    Forget();
  }
  return changed;
}

std::list<TerrainFollower::Step>::iterator TerrainFollower::FindApplicable() {
  return std::find_if(pending_.begin(), pending_.end(), [this](const Step& step) {
    const bool fits = map_ && step.map_id == map_->map_id && step.base_seq == map_->seq;
    return step.num_missing == 0 && (step.snapshot || fits);
  });
}

/// False, and nothing has changed, when a value in it cannot be meant.
bool TerrainFollower::Apply(const Step& step) {
  std::map<std::int64_t, std::shared_ptr<const TerrainRegion>> regions;
  if (!step.snapshot) regions = regions_;
  auto map = std::make_shared<TerrainMap>();
  for (const auto& part : step.parts) {
    for (const std::int64_t id : part->removed_ids) regions.erase(id);
  }
  for (const auto& part : step.parts) {
    for (const region_v1_t& message : part->regions) {
      std::optional<TerrainRegion> region = FromMessage(message);
      if (!region) return false;
      regions[region->id] = std::make_shared<const TerrainRegion>(std::move(*region));
    }
    for (const staircase_v1_t& message : part->staircases) {
      std::optional<Staircase> staircase = FromMessage(message);
      if (!staircase) return false;
      map->staircases.push_back(std::move(*staircase));
    }
  }
  const terrain_v1_t& head = *step.parts.front();
  const std::optional<TerrainView> view = FromMessage(head);
  if (!view) return false;
  map->t_capture = view->t_capture;
  map->seq = head.seq;
  map->map_id = head.map_id;
  map->T_world_left = view->T_world_left;
  map->gravity.down_world = view->down_world;
  for (const auto& [id, region] : regions) map->regions.push_back(region);
  if (map_ && map_->map_id != map->map_id) Retire(map_->map_id);
  regions_ = std::move(regions);
  map_ = std::move(map);
  return true;
}

/// What the new state has made outdated.
void TerrainFollower::Forget() {
  std::erase_if(pending_, [&](const Step& step) {
    if (!IsOutdated(step.map_id, step.seq)) return false;
    pending_bytes_ -= step.num_bytes;
    return true;
  });
}

void TerrainFollower::Retire(std::int64_t map_id) { retired_[map_id] = num_messages_; }

}  // namespace terrace
