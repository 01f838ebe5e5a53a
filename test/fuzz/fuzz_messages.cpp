// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>

#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>
#include <terrace/terrain_repair_v1_t.hpp>

#include "client/terrain_follower.h"
#include "lcmtypes/calibration_codec.h"
#include "lcmtypes/image_codec.h"
#include "lcmtypes/map_transform_codec.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/region_codec.h"
#include "lcmtypes/request_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/sensor_codec.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/terrain_codec.h"
#include "test/fuzz/fuzz_targets.h"

namespace terrace::fuzz {
namespace {

/// The fingerprint is put before the bytes: nobody guesses eight of them.
template <typename Message>
std::vector<std::uint8_t> WithFingerprint(Bytes bytes) {
  std::vector<std::uint8_t> message(8);
  const std::int64_t hash = Message::getHash();
  for (int i = 0; i < 8; ++i)
    message[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(static_cast<std::uint64_t>(hash) >> (56 - 8 * i));
  message.insert(message.end(), bytes.begin(), bytes.end());
  return message;
}

template <typename Message>
std::optional<Message> Decoded(Bytes bytes) {
  const std::vector<std::uint8_t> message = WithFingerprint<Message>(bytes);
  return SafeDecode<Message>(message.data(), message.size());
}

/// What decodes is read, too.
template <typename Message>
void ReadMessage(Bytes bytes) {
  if (const auto message = Decoded<Message>(bytes)) FromMessage(*message);
}
template <typename Message>
void OnlyDecode(Bytes bytes) {
  Decoded<Message>(bytes);
}

/// Parts of a map, each with its length in two bytes before it.
void FollowTerrain(Bytes bytes) {
  TerrainFollower follower;
  TerrainFollower::Time now{};
  while (bytes.size() >= 2) {
    const std::size_t size = std::min<std::size_t>(bytes[0] | bytes[1] << 8, bytes.size() - 2);
    const auto message = WithFingerprint<terrain_v1_t>(bytes.subspan(2, size));
    follower.Receive(message.data(), message.size(), now);
    follower.TakeRepair(now);
    now += std::chrono::milliseconds(100);
    bytes = bytes.subspan(2 + size);
  }
}

}  // namespace

std::vector<Target> MessageTargets() {
  return {{"images", ReadMessage<images_t>},
          {"imu", ReadMessage<imu_v1_t>},
          {"body_prior", ReadMessage<body_prior_v1_t>},
          {"calibration_message", ReadMessage<calibration_v1_t>},
          {"pose", ReadMessage<pose_v1_t>},
          {"plain_pose", ReadMessage<pose_t>},
          {"region", ReadMessage<region_v1_t>},
          {"staircase", ReadMessage<staircase_v1_t>},
          {"status", ReadMessage<status_v1_t>},
          {"terrain", ReadMessage<terrain_v1_t>},
          {"command", OnlyDecode<command_v1_t>},
          {"command_reply", OnlyDecode<command_reply_v1_t>},
          {"map_transform", ReadMessage<map_transform_v1_t>},
          {"request", ReadMessage<terrain_request_v1_t>},
          {"repair", OnlyDecode<terrain_repair_v1_t>},
          {"terrain_parts", FollowTerrain}};
}

}  // namespace terrace::fuzz
