// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_feed.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/check.h"
#include "core/map_difference.h"
#include "lcmtypes/terrain_codec.h"

namespace terrace {
namespace {

constexpr std::size_t kMaxEvents = 256;
constexpr std::size_t kMaxWay = 4000;
// A WebSocket has no packets to fit into.
constexpr std::size_t kOnePart = std::numeric_limits<std::int32_t>::max();

ViewBytes TerrainRecord(const TerrainMap& map, Timestamp t_heard, const std::vector<terrain_v1_t>& parts) {
  TERRACE_CHECK(parts.size() == 1, parts.size());
  return MakeViewRecord(ViewRecordKind::kTerrain, map.t_capture, t_heard, parts.front());
}

}  // namespace

void ViewFeed::TakeMap(TerrainMapPtr map, Timestamp t_heard) {
  map_ = std::move(map);
  t_map_heard_ = t_heard;
}

void ViewFeed::TakePose(const BodyPose& pose, ViewBytes record) {
  TakeEvent(record);
  if (pose.epoch != epoch_) {
    way_.clear();
    way_places_.clear();
    way_step_m_ = kFirstStepM;
    epoch_ = pose.epoch;
  }
  if (!pose.T_world_body) return;
  const Eigen::Vector3d place = pose.T_world_body->translation();
  if (!way_places_.empty() && (place - way_places_.back()).norm() < way_step_m_) return;
  way_.push_back(std::move(record));
  way_places_.push_back(place);
  if (way_.size() < kMaxWay) return;
  // Every second one goes; the way stays as long as it is.
  for (std::size_t i = 0; 2 * i < way_.size(); ++i) {
    way_[i] = way_[2 * i];
    way_places_[i] = way_places_[2 * i];
  }
  way_.resize((way_.size() + 1) / 2);
  way_places_.resize(way_.size());
  way_step_m_ *= 2.0;
}

void ViewFeed::TakeEvent(ViewBytes record) {
  events_.push_back(std::move(record));
  ++next_event_;
  if (events_.size() > kMaxEvents) events_.pop_front();
}

void ViewCursor::Restart() {
  start_.assign(1, feed_->hello_);
  start_.insert(start_.end(), feed_->way_.begin(), feed_->way_.end());
  sent_.fill(nullptr);
  sent_map_ = nullptr;
  seen_again_.clear();
  next_event_ = feed_->next_event_;
}

ViewBytes ViewCursor::Next() {
  if (!start_.empty()) {
    ViewBytes record = std::move(start_.front());
    start_.pop_front();
    return record;
  }
  for (const ViewSlot slot : {ViewSlot::kCamera, ViewSlot::kPlan}) {
    if (ViewBytes record = NextOfSlot(slot)) return record;
  }
  const auto num_kept = static_cast<std::int64_t>(feed_->events_.size());
  const std::int64_t first_kept = feed_->next_event_ - num_kept;
  if (next_event_ < first_kept) {
    num_skipped_ += first_kept - next_event_;
    next_event_ = first_kept;
  }
  if (next_event_ < feed_->next_event_) {
    return feed_->events_[static_cast<std::size_t>(next_event_++ - first_kept)];
  }
  if (ViewBytes record = NextOfMap()) return record;
  for (const ViewSlot slot : {ViewSlot::kImage, ViewSlot::kDisparity, ViewSlot::kCells, ViewSlot::kPoints}) {
    if (!wants_.Has(slot)) continue;
    if (ViewBytes record = NextOfSlot(slot)) return record;
  }
  return nullptr;
}

/// Null when it has been sent.
ViewBytes ViewCursor::NextOfSlot(ViewSlot slot) {
  const auto i = static_cast<std::size_t>(slot);
  if (feed_->newest_[i] == sent_[i]) return nullptr;
  return sent_[i] = feed_->newest_[i];
}

/// Tells what has changed by region and revision; whole only where there is nothing to start from.
ViewBytes ViewCursor::NextOfMap() {
  const TerrainMapPtr& map = feed_->map_;
  if (!seen_again_.empty()) {
    std::vector<SeenRegion> seen;
    for (const auto& region : sent_map_->regions) {
      if (std::binary_search(seen_again_.begin(), seen_again_.end(), region->id))
        seen.push_back({region->id, region->last_seen});
    }
    seen_again_.clear();
    return TerrainRecord(*sent_map_, feed_->t_map_heard_,
                         SeenMessages(*sent_map_, sent_map_->T_body_left, seen, kOnePart));
  }
  if (!map || map == sent_map_) return nullptr;
  const TerrainMapPtr before = std::exchange(sent_map_, map);
  if (!before || before->map_id != map->map_id) {
    return TerrainRecord(*map, feed_->t_map_heard_, SnapshotMessages(*map, kOnePart));
  }
  const MapDifference difference = DifferenceBetween(*before, *map);
  seen_again_ = difference.seen;
  if (before->seq != map->seq) {
    return TerrainRecord(*map, feed_->t_map_heard_,
                         DeltaMessages(before->seq, *map, difference, map->T_body_left, kOnePart));
  }
  return seen_again_.empty() ? nullptr : NextOfMap();
}

}  // namespace terrace
