// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/terrain_sender.h"

#include <algorithm>
#include <utility>

namespace terrace {
namespace {

using std::chrono::milliseconds;

/// What is kept for those who lost some of it.
constexpr std::size_t kMaxStepsBytes = 8u << 20;
/// Deltas up to this much are sent rather than a snapshot, however small the map.
constexpr std::size_t kAlwaysWorthBytes = 256u << 10;
/// For this long after it has begun, a snapshot is repaired for whoever has none of it.
constexpr milliseconds kFreshSnapshot(2000);
/// A part that left this recently is still under way to whoever says that it is missing.
constexpr milliseconds kUnderWay(12);
/// A snapshot leaves at this rate at most, and this much of it at once.
constexpr double kSnapshotBytesPerSecond = 4e6;
constexpr double kSnapshotBurstBytes = 64e3;
/// The newest state is named again this often after it was reached, at growing distances, so that who lost
/// its last part notices soon; afterwards every kHeartbeat.
constexpr int kNumReminders = 3;
constexpr milliseconds kFirstReminder(70);
constexpr milliseconds kHeartbeat(500);

double DistanceTo(const TerrainRegion& region, const Eigen::Vector3d& p_world) {
  double nearest = (region.centroid_world - p_world).squaredNorm();
  for (const Eigen::Vector3d& p : region.outline_world)
    nearest = std::min(nearest, (p - p_world).squaredNorm());
  return nearest;
}

std::vector<const TerrainRegion*> NearFirst(const TerrainMap& map) {
  std::vector<std::pair<double, const TerrainRegion*>> by_distance;
  for (const auto& region : map.regions)
    by_distance.emplace_back(DistanceTo(*region, map.T_world_left.translation()), region.get());
  std::stable_sort(by_distance.begin(), by_distance.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const TerrainRegion*> regions;
  for (const auto& [distance, region] : by_distance) regions.push_back(region);
  return regions;
}

/// What the subscriber says it lacks of a step; null when it does not mention the step.
const repair_step_v1_t* Mentioned(const terrain_repair_v1_t& repair, std::int8_t kind, std::int64_t seq) {
  const auto step = std::find_if(repair.steps.begin(), repair.steps.end(),
                                 [&](const auto& s) { return s.kind == kind && s.seq == seq; });
  return step == repair.steps.end() ? nullptr : &*step;
}

}  // namespace

TerrainSender::TerrainSender(std::optional<Eigen::Isometry3d> T_body_left,
                             std::chrono::nanoseconds snapshot_period, std::int64_t first_map_id)
    : T_body_left_(std::move(T_body_left)), snapshot_period_(snapshot_period), first_map_id_(first_map_id) {}

std::vector<TerrainSender::Packet> TerrainSender::Update(const MapChange& change, Time now) {
  const TerrainMapPtr& map = change.map;
  std::vector<Packet> out;
  if (!map_ || map_->map_id != map->map_id) {
    steps_.clear();
    steps_bytes_ = 0;
    seen_.clear();
    map_ = map;
    t_seen_list_ = now;
    BeginSnapshot(now);
  } else {
    SendDelta(change, now, &out);
  }
  std::vector<Packet> due = Tick(now);
  out.insert(out.end(), std::make_move_iterator(due.begin()), std::make_move_iterator(due.end()));
  return out;
}

void TerrainSender::SendDelta(const MapChange& change, Time now, std::vector<Packet>* out) {
  const TerrainMapPtr& map = change.map;
  const MapDifference difference =
      change.before == map_ ? static_cast<const MapDifference&>(change) : DifferenceBetween(*map_, *map);
  NoteSeen(*map, difference.seen);
  const std::int64_t base_seq = map_->seq;
  map_ = map;
  if (map->seq == base_seq) return;
  SentStep step{terrain_v1_t::DELTA, base_seq, map->seq, {}, true};
  std::vector<terrain_v1_t> messages = DeltaMessages(base_seq, *map, difference, T_body_left_);
  for (terrain_v1_t& message : messages) message.map_id += first_map_id_;
  Record(messages, &step, now, out);
  steps_.push_back(std::move(step));
  ForgetOldSteps();
  t_announced_ = now;
  num_announced_ = 0;
}

void TerrainSender::NoteSeen(const TerrainMap& map, const std::vector<std::int64_t>& seen) {
  auto region = map.regions.begin();
  for (const std::int64_t id : seen) {
    while ((*region)->id < id) ++region;
    seen_[id] = (*region)->last_seen;
  }
}

std::vector<TerrainSender::Packet> TerrainSender::Tick(Time now) {
  std::vector<Packet> out;
  if (!map_) return out;
  const bool due = snapshot_wanted_ || now - t_snapshot_ >= snapshot_period_;
  if (!snapshot_ && due) BeginSnapshot(now);
  if (snapshot_) AdvanceSnapshot(now, &out);
  Announce(now, &out);
  return out;
}

bool TerrainSender::RequestSnapshot() {
  snapshot_wanted_ = map_ != nullptr;
  return snapshot_wanted_;
}

void TerrainSender::BeginSnapshot(Time now) {
  snapshot_wanted_ = false;
  snapshot_.emplace(Snapshot{map_, NearFirst(*map_), 0, TerrainParts(Head(*map_, terrain_v1_t::SNAPSHOT)),
                             now - milliseconds(1000)});
  for (const Staircase& staircase : map_->staircases) snapshot_->parts.Add(staircase);
  steps_.push_back({terrain_v1_t::SNAPSHOT, 0, map_->seq, {}, false});
  t_snapshot_ = now;
}

void TerrainSender::AdvanceSnapshot(Time now, std::vector<Packet>* out) {
  const double waited_s = std::chrono::duration<double>(now - snapshot_->t_advanced).count();
  const double budget = std::min(kSnapshotBurstBytes, kSnapshotBytesPerSecond * waited_s);
  // The one that is being sent is the newest.
  const auto step =
      std::find_if(steps_.rbegin(), steps_.rend(), [](const SentStep& s) { return !s.complete; });
  std::size_t sent = 0;
  while (static_cast<double>(sent) < budget) {
    const bool last = snapshot_->next == snapshot_->near_first.size();
    if (!last) snapshot_->parts.Add(*snapshot_->near_first[snapshot_->next++], snapshot_->map->gravity);
    const std::size_t before = steps_bytes_;
    Record(last ? snapshot_->parts.Finish() : snapshot_->parts.TakeFull(), &*step, now, out);
    sent += steps_bytes_ - before;
    if (!last) continue;
    step->complete = true;
    snapshot_bytes_ = 0;
    for (const SentPart& part : step->parts) snapshot_bytes_ += part.packet->size();
    t_announced_ = now;
    num_announced_ = 0;
    snapshot_.reset();
    ForgetOldSteps();
    return;
  }
  snapshot_->t_advanced = now;
}

void TerrainSender::Announce(Time now, std::vector<Packet>* out) {
  const bool list_due = now - t_seen_list_ >= kHeartbeat && !seen_.empty();
  const bool reminder_due =
      num_announced_ < kNumReminders && now - t_announced_ >= kFirstReminder * (1 << num_announced_);
  if (!list_due && !reminder_due && now - t_announced_ < kHeartbeat) return;
  std::vector<SeenRegion> seen;
  if (list_due) {
    for (const auto& [id, last_seen] : seen_) seen.push_back({id, last_seen});
    seen_.clear();
    t_seen_list_ = now;
  }
  for (terrain_v1_t& message : SeenMessages(*map_, T_body_left_, seen)) {
    message.map_id += first_map_id_;
    Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    out->push_back(std::make_shared<const Bytes>(std::move(bytes)));
  }
  t_announced_ = now;
  ++num_announced_;
}

std::vector<TerrainSender::Packet> TerrainSender::Answer(const terrain_repair_v1_t& repair, Time now) {
  std::vector<Packet> out;
  if (!map_) return out;
  const bool this_map = repair.map_id == map_id();
  const auto mentioned = [&](const SentStep& step) {
    return this_map ? Mentioned(repair, step.kind, step.seq) : nullptr;
  };
  std::int64_t base_seq = this_map ? repair.have_seq : -1;
  if (base_seq < 0 || !WorthDeltasSince(base_seq)) {
    SentStep* newest = NewestSnapshot();
    // One that has just been sent, or that the subscriber has begun to receive, is repaired, not sent anew.
    const bool fresh = newest != nullptr &&
                       (snapshot_ || now - t_snapshot_ < kFreshSnapshot || mentioned(*newest) != nullptr);
    if (!fresh || !WorthDeltasSince(newest->seq)) {
      if (!snapshot_) BeginSnapshot(now);
      AdvanceSnapshot(now, &out);
      return out;
    }
    base_seq = newest->seq;
    SendAgain(newest, mentioned(*newest), now, &out);
  }
  for (SentStep& step : steps_) {
    if (step.kind == terrain_v1_t::DELTA && step.seq > base_seq) SendAgain(&step, mentioned(step), now, &out);
  }
  return out;
}

/// @param lacks  null: everything
void TerrainSender::SendAgain(SentStep* step, const repair_step_v1_t* lacks, Time now,
                              std::vector<Packet>* out) {
  const auto send = [&](std::size_t number) {
    SentPart& part = step->parts[number];
    if (now - part.t_sent < kUnderWay) return;
    part.t_sent = now;
    out->push_back(part.packet);
  };
  std::size_t rest = lacks == nullptr ? 0 : step->parts.size();
  std::int64_t last = -1;
  for (const std::int64_t part : lacks == nullptr ? std::vector<std::int32_t>() : lacks->missing) {
    if (part == -1) rest = static_cast<std::size_t>(last + 1);
    if (part < 0 || part >= static_cast<std::int64_t>(step->parts.size())) continue;
    send(static_cast<std::size_t>(part));
    last = std::max(last, part);
  }
  for (; rest < step->parts.size(); ++rest) send(rest);
}

terrain_v1_t TerrainSender::Head(const TerrainMap& map, std::int8_t kind) const {
  terrain_v1_t head = TerrainHead(map, T_body_left_);
  head.map_id += first_map_id_;
  head.kind = kind;
  return head;
}

void TerrainSender::Record(const std::vector<terrain_v1_t>& messages, SentStep* step, Time now,
                           std::vector<Packet>* out) {
  for (const terrain_v1_t& message : messages) {
    Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    steps_bytes_ += bytes.size();
    step->parts.push_back({std::make_shared<const Bytes>(std::move(bytes)), now});
    out->push_back(step->parts.back().packet);
  }
}

void TerrainSender::ForgetOldSteps() {
  while (steps_bytes_ > kMaxStepsBytes && steps_.size() > 1 && steps_.front().complete) {
    for (const SentPart& part : steps_.front().parts) steps_bytes_ -= part.packet->size();
    steps_.pop_front();
  }
}

TerrainSender::SentStep* TerrainSender::NewestSnapshot() {
  const auto step = std::find_if(steps_.rbegin(), steps_.rend(),
                                 [](const SentStep& s) { return s.kind == terrain_v1_t::SNAPSHOT; });
  return step == steps_.rend() ? nullptr : &*step;
}

/// True when the deltas that are kept lead from this state to the newest one and are less than a snapshot.
bool TerrainSender::WorthDeltasSince(std::int64_t seq) const {
  if (seq == map_->seq) return true;
  bool reached = false;
  std::size_t bytes = 0;
  for (const SentStep& step : steps_) {
    if (step.kind != terrain_v1_t::DELTA || step.seq <= seq) continue;
    reached = reached || step.base_seq == seq;
    for (const SentPart& part : step.parts) bytes += part.packet->size();
  }
  return reached && bytes <= std::max(kAlwaysWorthBytes, snapshot_bytes_);
}

}  // namespace terrace
