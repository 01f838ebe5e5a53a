// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/map_transform_codec.h"

#include "lcmtypes/codec_values.h"

namespace terrace {

map_transform_v1_t ToMessage(const MapTransform& transform) {
  map_transform_v1_t message{};
  message.utime = transform.t.utime();
  message.t_capture_ns = transform.t.ns;
  message.map_id = transform.map_id;
  message.file = transform.file;
  message.placing = static_cast<std::int8_t>(transform.placing);
  message.reason = transform.reason;
  if (transform.placing == MapPlacing::kNotFound) return message;
  WritePose(transform.T_map_world, message.pos, message.quat);
  for (int i = 0; i < 36; ++i) message.cov[i] = transform.covariance(i / 6, i % 6);
  return message;
}

std::optional<MapTransform> FromMessage(const map_transform_v1_t& message) {
  const auto t = TimeFrom(message.utime, message.t_capture_ns);
  const auto placing = EnumFrom<MapPlacing>(message.placing, kNumMapPlacings);
  if (!t || !placing || message.map_id < 0 || !AllFinite(message.cov)) return std::nullopt;
  MapTransform transform;
  transform.t = *t;
  transform.map_id = message.map_id;
  transform.file = message.file;
  transform.placing = *placing;
  transform.reason = message.reason;
  const bool unknown = IsUnknownPose(message.quat);
  if (unknown != (*placing == MapPlacing::kNotFound)) return std::nullopt;
  if (unknown) return transform;
  const auto T_map_world = ReadPose(message.pos, message.quat);
  if (!T_map_world) return std::nullopt;
  transform.T_map_world = *T_map_world;
  for (int i = 0; i < 36; ++i) transform.covariance(i / 6, i % 6) = message.cov[i];
  return transform;
}

}  // namespace terrace
