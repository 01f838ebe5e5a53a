// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrain_follower.h"

#include <algorithm>
#include <utility>

#include "lcmtypes/region_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/terrain_codec.h"

namespace terrace {
namespace {

using std::chrono::milliseconds;

// Far above any map; what strangers on the bus can make us keep.
constexpr std::int32_t kMaxParts = 1 << 20;
constexpr std::size_t kMaxPending = 256;
constexpr std::size_t kMaxPendingBytes = 64u << 20;
// For this many messages, what belongs to a map that was replaced is taken for late; afterwards it could be
// that the daemon went back to it.
constexpr std::int64_t kRetiredMessages = 200;
// Packets overtake one another by this much; what is missing for longer is lost.
constexpr milliseconds kLostAfter(10);
// Between two questions: longer than an answer takes; and as long as nobody answers at all.
constexpr milliseconds kAskAgain(25);
constexpr milliseconds kAskIntoSilence(100);
// For this long a number of a state is believed to be the newest one.
constexpr milliseconds kBelieved(1000);
// A question fits one packet.
constexpr std::size_t kMaxListedSteps = 40;
constexpr std::size_t kMaxListedParts = 120;

bool MakesSense(const terrain_v1_t& message) {
  if (message.kind == terrain_v1_t::SEEN) return true;
  const bool kind = message.kind == terrain_v1_t::SNAPSHOT ||
                    (message.kind == terrain_v1_t::DELTA && message.base_seq < message.seq);
  return kind && message.part >= 0 && message.part < kMaxParts && message.n_parts >= 0 &&
         message.n_parts <= kMaxParts && (message.n_parts == 0 || message.part < message.n_parts);
}

/// The pieces of every region in the parts, by region, in order.
using Pieces = std::map<std::int64_t, std::map<int, const region_v1_t*>>;

}  // namespace

bool TerrainFollower::Receive(const void* data, std::size_t size, Time now) {
  std::optional<terrain_v1_t> message = SafeDecode<terrain_v1_t>(data, size);
  if (!message || !MakesSense(*message)) {
    ++num_bad_messages_;
    return false;
  }
  ++num_messages_;
  t_heard_ = now;
  std::erase_if(retired_, [&](const auto& entry) { return num_messages_ - entry.second > kRetiredMessages; });
  if (retired_.contains(message->map_id)) return false;
  HearOf(*message, now);
  if (message->kind == terrain_v1_t::SEEN) return SeeAgain(*message);
  if (IsOutdated(message->map_id, message->seq)) return false;
  return AddPart(std::make_shared<const terrain_v1_t>(std::move(*message)), size, now) && ApplyAll();
}

bool TerrainFollower::in_step() const {
  return map_ && map_->map_id == newest_map_id_ && map_->seq >= newest_seq_;
}

bool TerrainFollower::IsOutdated(std::int64_t map_id, std::int64_t seq) const {
  return retired_.contains(map_id) || (map_ && map_id == map_->map_id && seq <= map_->seq);
}

void TerrainFollower::HearOf(const terrain_v1_t& message, Time now) {
  // What the daemon itself says of its newest state corrects a number that nobody has sent since.
  const bool corrects = message.kind == terrain_v1_t::SEEN && now - t_newest_ > kBelieved;
  if (message.map_id == newest_map_id_ && message.seq <= newest_seq_ && !corrects) return;
  if (message.map_id == newest_map_id_ && message.seq == newest_seq_) return;
  newest_map_id_ = message.map_id;
  newest_seq_ = message.seq;
  t_newest_ = now;
}

/// True when the part completed a step.
bool TerrainFollower::AddPart(Part part, std::size_t size, Time now) {
  const bool snapshot = part->kind == terrain_v1_t::SNAPSHOT;
  auto step = std::find_if(pending_.begin(), pending_.end(), [&](const Step& s) {
    return s.map_id == part->map_id && s.seq == part->seq && s.snapshot == snapshot &&
           s.base_seq == part->base_seq;
  });
  if (step == pending_.end()) {
    pending_.push_back({part->map_id, part->seq, part->base_seq, snapshot, {}, 0, 0, now});
    step = std::prev(pending_.end());
  }
  // A number of parts that contradicts what is there already is nonsense.
  const bool fits =
      part->n_parts == 0 || ((step->num_parts == 0 || step->num_parts == part->n_parts) &&
                             (step->parts.empty() || step->parts.rbegin()->first < part->n_parts));
  if (!fits || (step->num_parts > 0 && part->part >= step->num_parts)) {
    ++num_bad_messages_;
    return false;
  }
  if (part->n_parts > 0) step->num_parts = part->n_parts;
  const std::int32_t number = part->part;
  if (!step->parts.emplace(number, std::move(part)).second) return false;
  step->num_bytes += size;
  step->t_last = now;
  pending_bytes_ += size;
  const bool complete = step->complete();
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
    return step.complete() && (step.snapshot || fits);
  });
}

/// False, and nothing has changed, when a value in it cannot be meant.
bool TerrainFollower::Apply(const Step& step) {
  const std::optional<TerrainMap> head = FromMessage(*step.parts.begin()->second);
  if (!head) return false;
  std::vector<std::shared_ptr<const TerrainRegion>> regions;
  std::vector<Staircase> staircases;
  Pieces pieces;
  for (const auto& [number, part] : step.parts) {
    for (const region_v1_t& piece : part->regions) pieces[piece.id][piece.piece] = &piece;
    for (const staircase_v1_t& message : part->staircases) {
      std::optional<Staircase> staircase = FromMessage(message);
      if (!staircase) return false;
      staircases.push_back(std::move(*staircase));
    }
  }
  for (const auto& [id, by_number] : pieces) {
    std::vector<const region_v1_t*> in_order;
    for (const auto& [number, piece] : by_number) in_order.push_back(piece);
    std::optional<TerrainRegion> region = RegionFromPieces(in_order);
    if (!region) return false;
    regions.push_back(std::make_shared<const TerrainRegion>(std::move(*region)));
  }

  if (step.snapshot) {
    regions_.clear();
    staircases_.clear();
  }
  for (const auto& [number, part] : step.parts) {
    for (const std::int64_t id : part->removed_ids) regions_.erase(id);
    for (const std::int64_t id : part->removed_staircase_ids) staircases_.erase(id);
  }
  for (auto& region : regions) regions_[region->id] = std::move(region);
  for (Staircase& staircase : staircases) staircases_[staircase.id] = std::move(staircase);
  if (map_ && map_->map_id != head->map_id) Retire(map_->map_id);
  MakeMap(*head);
  return true;
}

/// The map of the regions and staircases that stand.
void TerrainFollower::MakeMap(const TerrainMap& head) {
  auto map = std::make_shared<TerrainMap>(head);
  std::map<std::int64_t, std::vector<std::int64_t>> regions_of;
  map->regions.reserve(regions_.size());
  for (const auto& [id, region] : regions_) {
    map->regions.push_back(region);
    if (region->staircase_id) regions_of[*region->staircase_id].push_back(id);
  }
  for (const auto& [id, staircase] : staircases_) {
    map->staircases.push_back(staircase);
    map->staircases.back().region_ids = std::move(regions_of[id]);
  }
  map_ = std::move(map);
}

/// The state stands; what is known of when it was seen, and of where the robot is, goes on.
bool TerrainFollower::SeeAgain(const terrain_v1_t& message) {
  if (!map_ || message.map_id != map_->map_id || message.seq != map_->seq) return false;
  const std::optional<TerrainMap> head = FromMessage(message);
  if (!head) {
    ++num_bad_messages_;
    return false;
  }
  if (head->t_capture < map_->t_capture) return false;
  for (const SeenRegion& seen : SeenIn(message)) {
    const auto region = regions_.find(seen.id);
    if (region == regions_.end() || seen.last_seen <= region->second->last_seen) continue;
    auto again = std::make_shared<TerrainRegion>(*region->second);
    again->last_seen = seen.last_seen;
    region->second = std::move(again);
  }
  MakeMap(*head);
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

bool TerrainFollower::ShouldAsk(Time now) const {
  if (in_step()) return false;
  const bool answered = t_asked_ && t_heard_ >= *t_asked_;
  if (t_asked_ && now - *t_asked_ < (answered ? kAskAgain : kAskIntoSilence)) return false;
  if (newest_map_id_ == 0) return true;
  // What has just come goes on coming.
  const auto quiet = [&](const Step& step) { return now - step.t_last >= kLostAfter; };
  return now - t_newest_ >= kLostAfter || std::any_of(pending_.begin(), pending_.end(), quiet);
}

std::optional<terrain_repair_v1_t> TerrainFollower::TakeRepair(Time now) {
  if (!ShouldAsk(now)) return std::nullopt;
  t_asked_ = now;
  terrain_repair_v1_t repair{};
  repair.map_id = newest_map_id_;
  repair.have_seq = map_ && map_->map_id == newest_map_id_ ? map_->seq : -1;
  std::size_t num_listed = 0;
  for (const Step& step : pending_) {
    if (step.map_id != newest_map_id_ || repair.steps.size() == kMaxListedSteps) continue;
    repair_step_v1_t lacks{};
    lacks.kind = step.snapshot ? terrain_v1_t::SNAPSHOT : terrain_v1_t::DELTA;
    lacks.seq = step.seq;
    const std::int32_t end = step.num_parts > 0 ? step.num_parts : step.parts.rbegin()->first + 1;
    for (std::int32_t part = 0; part < end && num_listed < kMaxListedParts; ++part) {
      if (step.parts.contains(part)) continue;
      lacks.missing.push_back(part);
      ++num_listed;
    }
    if (step.num_parts == 0 && now - step.t_last >= kLostAfter) {
      lacks.missing.push_back(end);
      lacks.missing.push_back(-1);
    }
    lacks.n_missing = static_cast<std::int32_t>(lacks.missing.size());
    repair.steps.push_back(std::move(lacks));
  }
  repair.n_steps = static_cast<std::int32_t>(repair.steps.size());
  return repair;
}

}  // namespace terrace
