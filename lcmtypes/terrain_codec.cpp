// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/terrain_codec.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/check.h"
#include "lcmtypes/codec_values.h"
#include "lcmtypes/region_codec.h"

namespace terrace {
namespace {

/// How long before `now`, as seen_age_ms carries it.
std::int16_t AgeMs(Timestamp last_seen, Timestamp now) {
  const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(now - last_seen).count();
  return static_cast<std::int16_t>(
      std::clamp<std::int64_t>(age, 0, std::numeric_limits<std::int16_t>::max()));
}

bool IsEmpty(const terrain_v1_t& part) {
  return part.n_regions == 0 && part.n_removed == 0 && part.n_staircases == 0 &&
         part.n_removed_staircases == 0;
}

const TerrainRegion* RegionOf(const TerrainMap& map, std::int64_t id) {
  const auto found = std::lower_bound(map.regions.begin(), map.regions.end(), id,
                                      [](const auto& region, std::int64_t i) { return region->id < i; });
  return found != map.regions.end() && (*found)->id == id ? found->get() : nullptr;
}

}  // namespace

terrain_v1_t TerrainHead(const TerrainMap& map, const std::optional<Eigen::Isometry3d>& T_body_left) {
  terrain_v1_t head{};
  head.utime = map.t_capture.utime();
  head.t_capture_ns = map.t_capture.ns;
  head.map_id = map.map_id;
  head.seq = map.seq;
  head.epoch = map.epoch;
  head.frame_id = "world";
  WritePose(map.T_world_left, head.sensor_pos, head.sensor_quat);
  if (T_body_left) WritePose(map.T_world_left * T_body_left->inverse(), head.body_pos, head.body_quat);
  WriteTriangle<6>(map.covariance, head.sensor_cov);
  WriteVector(map.gravity.down_world, head.gravity);
  head.gravity_sigma = static_cast<float>(map.gravity.sigma_rad);
  head.gravity_source = static_cast<std::int8_t>(map.gravity.source);
  return head;
}

std::optional<TerrainMap> FromMessage(const terrain_v1_t& message) {
  const auto t_capture = TimeFrom(message.utime, message.t_capture_ns);
  const auto T_world_left = ReadPose(message.sensor_pos, message.sensor_quat);
  const auto gravity_source = EnumFrom<GravitySource>(message.gravity_source, 5);
  const Eigen::Vector3d down_world = ReadVector(message.gravity);
  constexpr double kMaxLengthError = 1e-3;
  if (!t_capture || !T_world_left || !gravity_source || !AllFinite(message.sensor_cov) ||
      !(std::abs(down_world.norm() - 1.0) < kMaxLengthError) || !std::isfinite(message.gravity_sigma)) {
    return std::nullopt;
  }
  TerrainMap map;
  map.t_capture = *t_capture;
  map.seq = message.seq;
  map.map_id = message.map_id;
  map.epoch = message.epoch;
  map.T_world_left = *T_world_left;
  map.covariance = ReadTriangle<6>(message.sensor_cov);
  if (!IsUnknownPose(message.body_quat)) {
    const auto T_world_body = ReadPose(message.body_pos, message.body_quat);
    if (!T_world_body) return std::nullopt;
    map.T_body_left = T_world_body->inverse() * *T_world_left;
  }
  map.gravity = {down_world, message.gravity_sigma, *gravity_source};
  return map;
}

TerrainParts::TerrainParts(terrain_v1_t head, std::size_t max_bytes)
    : max_bytes_(max_bytes),
      blank_(std::move(head)),
      blank_bytes_(static_cast<std::size_t>(blank_.getEncodedSize())),
      parts_{blank_},
      bytes_(blank_bytes_) {}

terrain_v1_t& TerrainParts::PartWithRoomFor(std::size_t bytes) {
  if (bytes_ + bytes > max_bytes_ && !IsEmpty(parts_.back())) {
    parts_.push_back(blank_);
    bytes_ = blank_bytes_;
  }
  bytes_ += bytes;
  return parts_.back();
}

void TerrainParts::Remove(std::int64_t region_id) {
  terrain_v1_t& part = PartWithRoomFor(sizeof(region_id));
  part.removed_ids.push_back(region_id);
  ++part.n_removed;
}

void TerrainParts::RemoveStaircase(std::int64_t staircase_id) {
  terrain_v1_t& part = PartWithRoomFor(sizeof(staircase_id));
  part.removed_staircase_ids.push_back(staircase_id);
  ++part.n_removed_staircases;
}

void TerrainParts::Add(const Staircase& staircase) {
  staircase_v1_t message = ToMessage(staircase);
  terrain_v1_t& part = PartWithRoomFor(static_cast<std::size_t>(message._getEncodedSizeNoHash()));
  part.staircases.push_back(std::move(message));
  ++part.n_staircases;
}

void TerrainParts::Add(const TerrainRegion& region, const Gravity& gravity) {
  const std::size_t room = max_bytes_ > blank_bytes_ ? max_bytes_ - blank_bytes_ : 0;
  for (region_v1_t& piece : RegionPieces(region, gravity, room)) {
    terrain_v1_t& part = PartWithRoomFor(static_cast<std::size_t>(piece._getEncodedSizeNoHash()));
    part.regions.push_back(std::move(piece));
    ++part.n_regions;
  }
}

std::vector<terrain_v1_t> TerrainParts::TakeFull() {
  std::vector<terrain_v1_t> full(std::make_move_iterator(parts_.begin()),
                                 std::make_move_iterator(parts_.end() - 1));
  parts_.erase(parts_.begin(), parts_.end() - 1);
  for (terrain_v1_t& part : full) part.part = num_taken_++;
  return full;
}

std::vector<terrain_v1_t> TerrainParts::Finish() {
  std::vector<terrain_v1_t> rest = std::move(parts_);
  parts_.clear();
  const std::int32_t num_parts = num_taken_ + static_cast<std::int32_t>(rest.size());
  for (terrain_v1_t& part : rest) {
    part.part = num_taken_++;
    part.n_parts = num_parts;
  }
  return rest;
}

std::vector<terrain_v1_t> SnapshotMessages(const TerrainMap& map, std::size_t max_bytes) {
  terrain_v1_t head = TerrainHead(map, map.T_body_left);
  head.kind = terrain_v1_t::SNAPSHOT;
  TerrainParts parts(std::move(head), max_bytes);
  for (const Staircase& staircase : map.staircases) parts.Add(staircase);
  for (const auto& region : map.regions) parts.Add(*region, map.gravity);
  return parts.Finish();
}

std::vector<terrain_v1_t> DeltaMessages(std::int64_t base_seq, const TerrainMap& map,
                                        const MapDifference& difference,
                                        const std::optional<Eigen::Isometry3d>& T_body_left,
                                        std::size_t max_bytes) {
  terrain_v1_t head = TerrainHead(map, T_body_left);
  head.kind = terrain_v1_t::DELTA;
  head.base_seq = base_seq;
  TerrainParts parts(std::move(head), max_bytes);
  for (const std::int64_t id : difference.removed) parts.Remove(id);
  for (const std::int64_t id : difference.removed_staircases) parts.RemoveStaircase(id);
  for (const Staircase& staircase : map.staircases) {
    if (std::binary_search(difference.changed_staircases.begin(), difference.changed_staircases.end(),
                           staircase.id)) {
      parts.Add(staircase);
    }
  }
  for (const auto* ids : {&difference.added, &difference.revised}) {
    for (const std::int64_t id : *ids) {
      const TerrainRegion* region = RegionOf(map, id);
      TERRACE_CHECK(region != nullptr, id);
      parts.Add(*region, map.gravity);
    }
  }
  return parts.Finish();
}

std::vector<terrain_v1_t> DeltaMessages(const TerrainMap& base, const TerrainMap& map,
                                        std::size_t max_bytes) {
  TERRACE_CHECK(base.map_id == map.map_id, base.map_id, map.map_id);
  return DeltaMessages(base.seq, map, DifferenceBetween(base, map), map.T_body_left, max_bytes);
}

std::vector<terrain_v1_t> SeenMessages(const TerrainMap& map,
                                       const std::optional<Eigen::Isometry3d>& T_body_left,
                                       std::span<const SeenRegion> seen, std::size_t max_bytes) {
  constexpr std::size_t kSeenBytes = 8 + 2;
  terrain_v1_t head = TerrainHead(map, T_body_left);
  head.kind = terrain_v1_t::SEEN;
  head.n_parts = 1;
  const auto head_bytes = static_cast<std::size_t>(head.getEncodedSize());
  const std::size_t room =
      std::max<std::size_t>(1, (max_bytes - std::min(max_bytes, head_bytes)) / kSeenBytes);
  std::vector<terrain_v1_t> messages;
  do {
    terrain_v1_t message = head;
    for (const SeenRegion& region : seen.first(std::min(room, seen.size()))) {
      message.seen_ids.push_back(region.id);
      message.seen_age_ms.push_back(AgeMs(region.last_seen, map.t_capture));
    }
    message.n_seen = static_cast<std::int32_t>(message.seen_ids.size());
    seen = seen.subspan(message.seen_ids.size());
    messages.push_back(std::move(message));
  } while (!seen.empty());
  return messages;
}

std::vector<SeenRegion> SeenIn(const terrain_v1_t& message) {
  std::vector<SeenRegion> seen;
  const std::optional<Timestamp> t_capture = TimeFrom(message.utime, message.t_capture_ns);
  if (!t_capture) return seen;
  for (std::size_t i = 0; i < message.seen_ids.size(); ++i) {
    const std::chrono::milliseconds age(std::max<std::int16_t>(0, message.seen_age_ms[i]));
    seen.push_back({message.seen_ids[i], *t_capture - age});
  }
  return seen;
}

}  // namespace terrace
