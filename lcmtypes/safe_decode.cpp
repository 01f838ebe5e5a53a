// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/safe_decode.h"

#include <cstdint>
#include <limits>
#include <utility>

#include <terrace/body_prior_v1_t.hpp>
#include <terrace/calibration_v1_t.hpp>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>
#include <terrace/disparity_v1_t.hpp>
#include <terrace/footstep_plan_v1_t.hpp>
#include <terrace/height_map_v1_t.hpp>
#include <terrace/heightmap_t.hpp>
#include <terrace/image_metadata_t.hpp>
#include <terrace/image_t.hpp>
#include <terrace/images_t.hpp>
#include <terrace/imu_v1_t.hpp>
#include <terrace/input_stat_v1_t.hpp>
#include <terrace/localization_lcmt.hpp>
#include <terrace/map_transform_v1_t.hpp>
#include <terrace/octree_v1_t.hpp>
#include <terrace/pose_t.hpp>
#include <terrace/pose_v1_t.hpp>
#include <terrace/region_v1_t.hpp>
#include <terrace/repair_step_v1_t.hpp>
#include <terrace/stage_stat_v1_t.hpp>
#include <terrace/staircase_v1_t.hpp>
#include <terrace/status_v1_t.hpp>
#include <terrace/terrain_repair_v1_t.hpp>
#include <terrace/terrain_request_v1_t.hpp>
#include <terrace/terrain_v1_t.hpp>
#include <terrace/traversability_map_t.hpp>
#include <terrace/update_t.hpp>

namespace terrace {
namespace {

/// Walks over an encoded message without decoding it. The first step outside the buffer fails, and so does
/// every later one.
class Walker {
 public:
  Walker(const std::uint8_t* data, std::size_t size) : next_(data), left_(size) {}

  bool arrived() const { return ok_ && left_ == 0; }

  void Skip(std::size_t bytes) {
    if (!ok_ || bytes > left_) {
      ok_ = false;
      return;
    }
    next_ += bytes;
    left_ -= bytes;
  }

  /// Reads a count of items of which each takes `min_bytes` or more of what is still to come; 0 after a
  /// failure.
  std::size_t Count(std::size_t min_bytes) {
    const std::int32_t count = Int32();
    if (count < 0 || static_cast<std::size_t>(count) > left_ / min_bytes) ok_ = false;
    return ok_ ? static_cast<std::size_t>(count) : 0;
  }

  /// A string has a length of at least 1, its closing zero included.
  void String() {
    const std::size_t length = Count(1);
    if (length == 0 || next_[length - 1] != 0) ok_ = false;
    Skip(length);
  }

  template <typename WalkItem>
  void Items(std::size_t count, WalkItem walk_item) {
    for (std::size_t i = 0; i < count && ok_; ++i) walk_item();
  }

 private:
  std::int32_t Int32() {
    if (!ok_ || left_ < 4) {
      ok_ = false;
      return 0;
    }
    const std::uint32_t value = std::uint32_t{next_[0]} << 24 | std::uint32_t{next_[1]} << 16 |
                                std::uint32_t{next_[2]} << 8 | std::uint32_t{next_[3]};
    Skip(4);
    return static_cast<std::int32_t>(value);
  }

  const std::uint8_t* next_;
  std::size_t left_;
  bool ok_ = true;
};

// One walk a type, in the order of its members. The test SafeDecodeTest.KnowsTheLayoutOfEveryType compares
// the fingerprints with those of the day on which these were written.

void Walk(Walker& walker, const pose_t*) { walker.Skip(8 + 8 * (3 + 3 + 4 + 3 + 3)); }

void Walk(Walker& walker, const pose_v1_t*) {
  walker.Skip(8 + 8 + 8 + 4 + 1 + 2);
  walker.String();
  walker.String();
  walker.Skip(8 * (3 + 4 + 36) + 1 + 8 * (3 + 3));
}

void Walk(Walker& walker, const update_t*) { walker.Skip(8 + 8 + 8 * (3 + 4 + 36) + 1); }

void Walk(Walker& walker, const imu_v1_t*) { walker.Skip(8 + 8 + 8 * (3 + 3)); }

void Walk(Walker& walker, const body_prior_v1_t*) { walker.Skip(8 + 8 + 1 + 8 * (3 + 4 + 36)); }

void Walk(Walker& walker, const image_metadata_t*) {
  walker.String();
  walker.Skip(walker.Count(1));
}
constexpr std::size_t kMinImageMetadata = 4 + 1 + 4;

void Walk(Walker& walker, const image_t*) {
  walker.Skip(8 + 4 * 4);
  walker.Skip(walker.Count(1));
  walker.Items(walker.Count(kMinImageMetadata),
               [&] { Walk(walker, static_cast<const image_metadata_t*>(nullptr)); });
}
constexpr std::size_t kMinImage = 8 + 4 * 4 + 4 + 4;

void Walk(Walker& walker, const images_t*) {
  walker.Skip(8);
  const std::size_t num_images = walker.Count(2 + kMinImage);
  walker.Skip(2 * num_images);
  walker.Items(num_images, [&] { Walk(walker, static_cast<const image_t*>(nullptr)); });
}

void Walk(Walker& walker, const calibration_v1_t*) {
  walker.Skip(8);
  walker.String();
  walker.String();
  walker.Skip(4 + 4 + 1 + 8 * 2 * 9);
  walker.Skip(2 * 8 * walker.Count(2 * 8));
  walker.String();
  walker.Skip(8 * (9 + 3 + 3 + 4 + 3 + 4 + 4));
}

void Walk(Walker& walker, const command_v1_t*) {
  walker.Skip(8 + 8 + 1);
  walker.String();
}

void Walk(Walker& walker, const command_reply_v1_t*) {
  walker.Skip(8 + 8 + 1);
  walker.String();
}

void Walk(Walker& walker, const terrain_request_v1_t*) {
  walker.Skip(8 + 8 + 1 + 4 + 4 + 1 + 8 * (3 + 3) + 8);
}

void Walk(Walker& walker, const disparity_v1_t*) {
  walker.Skip(8 + 8 + 4 + 4 + 8 * 5 + 1 + 8 * (3 + 4));
  walker.Skip(2 * walker.Count(2));
}

void Walk(Walker& walker, const height_map_v1_t*) {
  walker.Skip(8 + 8 + 8);
  walker.String();
  walker.Skip(8 * (3 + 1) + 4 + 4 + 4);
  walker.Items(walker.Count(4 + 1), [&] { walker.String(); });
  walker.Skip(4 * walker.Count(4));
}

void Walk(Walker& walker, const octree_v1_t*) {
  walker.Skip(8 + 8 + 8);
  walker.String();
  walker.Skip(4 + 8 * (3 + 3) + 1);
  walker.Skip(walker.Count(1));
}

void Walk(Walker& walker, const stage_stat_v1_t*) {
  walker.String();
  walker.Skip(8 * 3 + 4 + 4 * 4);
}
constexpr std::size_t kMinStageStat = 4 + 1 + 8 * 3 + 4 + 4 * 4;

void Walk(Walker& walker, const input_stat_v1_t*) {
  walker.String();
  walker.String();
  walker.Skip(8 + 8 + 4 + 4);
}
constexpr std::size_t kMinInputStat = 2 * (4 + 1) + 8 + 8 + 4 + 4;

void Walk(Walker& walker, const status_v1_t*) {
  walker.Skip(8 + 8);
  walker.String();
  walker.String();
  walker.Skip(8 + 4 * 1 + 4);
  walker.String();
  walker.Skip(2 + 8 + 8 + 4);
  walker.Skip(4 * 5 + 8 * 6 + 4 * 2 + 4 * 3 + 8 + 4 + 8 + 8 + 4);
  walker.Items(walker.Count(kMinInputStat),
               [&] { Walk(walker, static_cast<const input_stat_v1_t*>(nullptr)); });
  walker.Items(walker.Count(kMinStageStat),
               [&] { Walk(walker, static_cast<const stage_stat_v1_t*>(nullptr)); });
}

constexpr std::size_t kRegionBeforeWhy = 8 + 4 + 1 + 1 + 4;
constexpr std::size_t kRegionBehindWhy = 8 + 8 + 4 + 8 * (3 + 4) + 4 * 6 + 4 * 4 + 8 + 4 + 2 + 2 + 1;
void Walk(Walker& walker, const region_v1_t*) {
  walker.Skip(kRegionBeforeWhy);
  walker.String();
  walker.Skip(kRegionBehindWhy);
  walker.Skip(4 * walker.Count(4));
  constexpr std::size_t kEdgeBytes = 1 + 4 + 4;
  const std::size_t num_vertices = walker.Count(kEdgeBytes);
  walker.Skip(4 * walker.Count(4));
  walker.Skip(kEdgeBytes * num_vertices);
}
constexpr std::size_t kMinRegion = kRegionBeforeWhy + 4 + 1 + kRegionBehindWhy + 3 * 4;

constexpr std::size_t kStaircase = 8 + 8 + 4 + 4 + 4 * 5 + 8 * (6 + 6) + 4 * (3 + 3);
void Walk(Walker& walker, const staircase_v1_t*) { walker.Skip(kStaircase); }

void Walk(Walker& walker, const terrain_v1_t*) {
  walker.Skip(8 + 8 + 8 + 8 + 4);
  walker.String();
  walker.Skip(8 * (3 + 4 + 3 + 4) + 4 * 21 + 8 * 3 + 4 + 1 + 1 + 8 + 4 + 4);
  walker.Skip(8 * walker.Count(8));
  walker.Skip(8 * walker.Count(8));
  walker.Items(walker.Count(kMinRegion), [&] { Walk(walker, static_cast<const region_v1_t*>(nullptr)); });
  walker.Items(walker.Count(kStaircase), [&] { Walk(walker, static_cast<const staircase_v1_t*>(nullptr)); });
  constexpr std::size_t kSeenBytes = 8 + 2;
  walker.Skip(kSeenBytes * walker.Count(kSeenBytes));
}

void Walk(Walker& walker, const map_transform_v1_t*) {
  walker.Skip(8 + 8 + 8);
  walker.String();
  walker.Skip(1);
  walker.String();
  walker.Skip(8 * (3 + 4 + 36));
}

void Walk(Walker& walker, const footstep_plan_v1_t*) {
  walker.Skip(8 + 8 + 8);
  walker.String();
  walker.Skip(4);
  constexpr std::size_t kStepBytes = 1 + 8 * (3 + 3 + 1) + 4 + 1 + 8 + 1;
  walker.Skip(kStepBytes * walker.Count(kStepBytes));
}

void Walk(Walker& walker, const heightmap_t*) { walker.Skip(8 * (100 * 100 + 3)); }

void Walk(Walker& walker, const traversability_map_t*) { walker.Skip(4 * 100 * 100); }

void Walk(Walker& walker, const localization_lcmt*) { walker.Skip(4 * (3 + 3)); }

void Walk(Walker& walker, const repair_step_v1_t*) {
  walker.Skip(1 + 8);
  walker.Skip(4 * walker.Count(4));
}
constexpr std::size_t kMinRepairStep = 1 + 8 + 4;

void Walk(Walker& walker, const terrain_repair_v1_t*) {
  walker.Skip(8 + 8 + 8);
  walker.Items(walker.Count(kMinRepairStep),
               [&] { Walk(walker, static_cast<const repair_step_v1_t*>(nullptr)); });
}

}  // namespace

template <typename Message>
std::optional<Message> SafeDecode(const void* data, std::size_t size) {
  constexpr std::size_t kFingerprint = 8;
  if (data == nullptr || size < kFingerprint ||
      size > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    return std::nullopt;
  }
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  std::uint64_t fingerprint = 0;
  for (std::size_t i = 0; i < kFingerprint; ++i) fingerprint = fingerprint << 8 | bytes[i];
  if (fingerprint != static_cast<std::uint64_t>(Message::getHash())) return std::nullopt;
  Walker walker(bytes + kFingerprint, size - kFingerprint);
  Walk(walker, static_cast<const Message*>(nullptr));
  if (!walker.arrived()) return std::nullopt;
  Message message{};
  if (message.decode(data, 0, static_cast<int>(size)) != static_cast<int>(size)) return std::nullopt;
  return message;
}

template std::optional<body_prior_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<calibration_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<command_reply_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<command_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<disparity_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<footstep_plan_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<height_map_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<heightmap_t> SafeDecode(const void*, std::size_t);
template std::optional<image_metadata_t> SafeDecode(const void*, std::size_t);
template std::optional<image_t> SafeDecode(const void*, std::size_t);
template std::optional<images_t> SafeDecode(const void*, std::size_t);
template std::optional<imu_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<input_stat_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<localization_lcmt> SafeDecode(const void*, std::size_t);
template std::optional<map_transform_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<octree_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<pose_t> SafeDecode(const void*, std::size_t);
template std::optional<pose_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<region_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<repair_step_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<stage_stat_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<staircase_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<status_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<terrain_repair_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<terrain_request_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<terrain_v1_t> SafeDecode(const void*, std::size_t);
template std::optional<traversability_map_t> SafeDecode(const void*, std::size_t);
template std::optional<update_t> SafeDecode(const void*, std::size_t);

}  // namespace terrace
