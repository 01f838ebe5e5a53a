// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/request_codec.h"

#include <cmath>
#include <limits>

#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

constexpr float kStepsPerPixel = 64.0F;
constexpr double kLongest_s = 1e6;

}  // namespace

terrain_request_v1_t ToMessage(const TerrainRequest& request) {
  terrain_request_v1_t message{};
  message.request_id = request.id;
  message.what = static_cast<std::int8_t>(request.kind);
  message.rate = static_cast<float>(request.rate_hz);
  message.duration_s = static_cast<float>(Seconds(request.duration));
  message.around_robot = static_cast<std::int8_t>(request.around_robot);
  if (request.kind != RequestKind::kDisparity) {
    WriteVector(request.box.min(), message.box_min);
    WriteVector(request.box.max(), message.box_max);
  }
  message.resolution = request.resolution_m;
  return message;
}

std::optional<TerrainRequest> FromMessage(const terrain_request_v1_t& message) {
  TerrainRequest request;
  if (message.what < terrain_request_v1_t::HEIGHT_MAP || message.what > terrain_request_v1_t::MAP)
    return std::nullopt;
  if (!AllFinite(message.box_min) || !AllFinite(message.box_max) || !std::isfinite(message.rate) ||
      !std::isfinite(message.duration_s) || !std::isfinite(message.resolution) || message.rate < 0.0F ||
      message.duration_s < 0.0F || message.duration_s > kLongest_s || message.resolution < 0.0)
    return std::nullopt;
  request.id = message.request_id;
  request.kind = static_cast<RequestKind>(message.what);
  request.rate_hz = message.rate;
  request.duration =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(message.duration_s));
  request.around_robot = message.around_robot != 0;
  request.box = {ReadVector(message.box_min), ReadVector(message.box_max)};
  if (request.box.isEmpty()) return std::nullopt;
  request.resolution_m = message.resolution;
  return request;
}

disparity_v1_t DisparityHead(const StereoCamera& camera, Timestamp t_capture,
                             const std::optional<Eigen::Isometry3d>& T_world_left) {
  disparity_v1_t message{};
  message.utime = t_capture.utime();
  message.t_capture_ns = t_capture.ns;
  message.width = camera.width;
  message.height = camera.height;
  message.fx = camera.fx;
  message.fy = camera.fy;
  message.cx = camera.cx;
  message.cy = camera.cy;
  message.baseline_m = camera.baseline_m;
  message.pose_known = static_cast<std::int8_t>(T_world_left.has_value());
  if (T_world_left) WritePose(*T_world_left, message.pos, message.quat);
  return message;
}

std::int16_t DisparityNumber(float disparity_px) {
  const float number = std::round(kStepsPerPixel * disparity_px);
  const bool fits = number >= 1.0F && number <= float{std::numeric_limits<std::int16_t>::max()};
  return fits ? static_cast<std::int16_t>(number) : std::int16_t{0};
}

float DisparityFromNumber(std::int16_t number) {
  return number > 0 ? static_cast<float>(number) / kStepsPerPixel : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace terrace
