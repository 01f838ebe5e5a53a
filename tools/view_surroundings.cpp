// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_surroundings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "client/occupied_space.h"
#include "client/ot_cells.h"
#include "lcmtypes/codec_values.h"
#include "lcmtypes/request_codec.h"

namespace terrace {
namespace {

static_assert(std::endian::native == std::endian::little, "records are little endian");

template <typename Value>
void AppendBytes(Value value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

bool IsWhole(const disparity_v1_t& message) {
  constexpr int kMaxSide = 1 << 14;
  return message.width > 0 && message.height > 0 && message.width <= kMaxSide && message.height <= kMaxSide &&
         message.values.size() ==
             static_cast<std::size_t>(message.width) * static_cast<std::size_t>(message.height);
}

}  // namespace

ViewBytes CellsRecord(const octree_v1_t& message, Timestamp t_heard, const TerrainQuery* query) {
  if (message.encoding != octree_v1_t::OCTOMAP_OT) return nullptr;
  OccupiedCells octree;
  try {
    octree = ReadOtCells(message.data);
  } catch (const std::runtime_error&) {
    return nullptr;
  }
  std::erase_if(octree.cells, [&](const OccupiedCell& cell) {
    const double edge_m = cell.num_leaves * octree.leaf_m;
    const Eigen::Vector3d middle =
        octree.leaf_m * cell.corner.cast<double>() + Eigen::Vector3d::Constant(0.5 * edge_m);
    return query != nullptr && IsOnARegion(middle, 0.5 * edge_m, *query);
  });
  Eigen::Vector3i low = Eigen::Vector3i::Zero();
  if (!octree.cells.empty()) low = octree.cells.front().corner;
  for (const OccupiedCell& cell : octree.cells) low = low.cwiseMin(cell.corner);
  std::string content;
  AppendBytes(static_cast<float>(octree.leaf_m), &content);
  for (int axis = 0; axis < 3; ++axis) AppendBytes(static_cast<float>(octree.leaf_m * low[axis]), &content);
  for (const OccupiedCell& cell : octree.cells) {
    // OctoMap has no more than 2^16 leaves along an axis.
    for (int axis = 0; axis < 3; ++axis)
      AppendBytes(static_cast<std::uint16_t>(cell.corner[axis] - low[axis]), &content);
    AppendBytes(static_cast<std::uint16_t>(std::min(cell.num_leaves, 0xffff)), &content);
  }
  return MakeViewRecord(ViewRecordKind::kCells, Timestamp::FromMicroseconds(message.utime), t_heard,
                        content.data(), content.size());
}

ViewBytes DisparityRecord(const disparity_v1_t& message, Timestamp t_heard) {
  constexpr int kQuality = 80;
  if (!IsWhole(message)) return nullptr;
  float least_px = std::numeric_limits<float>::infinity(), greatest_px = 0.0F;
  for (const std::int16_t number : message.values) {
    const float disparity_px = DisparityFromNumber(number);
    if (!std::isfinite(disparity_px)) continue;
    least_px = std::min(least_px, disparity_px);
    greatest_px = std::max(greatest_px, disparity_px);
  }
  if (!(least_px <= greatest_px)) return nullptr;
  const float per_step = 255.0F / std::max(1.0F, greatest_px - least_px);
  cv::Mat1b steps(message.height, message.width);
  cv::Mat1b unknown(message.height, message.width);
  auto number = message.values.begin();
  for (int v = 0; v < steps.rows; ++v) {
    for (int u = 0; u < steps.cols; ++u, ++number) {
      const float disparity_px = DisparityFromNumber(*number);
      unknown(v, u) = std::isfinite(disparity_px) ? 0 : 255;
      steps(v, u) = unknown(v, u) != 0 ? 0 : static_cast<std::uint8_t>(per_step * (disparity_px - least_px));
    }
  }
  cv::Mat3b picture;
  cv::applyColorMap(steps, picture, cv::COLORMAP_VIRIDIS);
  picture.setTo(cv::Vec3b(0, 0, 0), unknown);
  std::vector<std::uint8_t> jpeg;
  if (!cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, kQuality})) return nullptr;
  std::string content;
  AppendBytes(least_px, &content);
  AppendBytes(greatest_px, &content);
  content.append(jpeg.begin(), jpeg.end());
  return MakeViewRecord(ViewRecordKind::kDisparity, Timestamp::FromMicroseconds(message.utime), t_heard,
                        content.data(), content.size());
}

ViewBytes PointsRecord(const disparity_v1_t& message, Timestamp t_heard, const TerrainQuery* query) {
  constexpr int kStride_px = 4;
  constexpr double kUnit_m = 0.002;
  constexpr double kMaxSigma_m = 0.05;  // of the depth, were every disparity known to a quarter of a pixel
  const std::array camera = {message.fx, message.fy, message.cx, message.cy, message.baseline_m};
  if (!IsWhole(message) || message.pose_known == 0 || !AllFinite(camera) || message.fx <= 0.0 ||
      message.fy <= 0.0 || message.baseline_m <= 0.0)
    return nullptr;
  const std::optional<Eigen::Isometry3d> T_world_left = ReadPose(message.pos, message.quat);
  if (!T_world_left) return nullptr;
  const Eigen::Vector3d camera_world = T_world_left->translation();
  std::string content;
  for (int axis = 0; axis < 3; ++axis) AppendBytes(static_cast<float>(camera_world[axis]), &content);
  AppendBytes(static_cast<float>(kUnit_m), &content);
  for (int v = 0; v < message.height; v += kStride_px) {
    for (int u = 0; u < message.width; u += kStride_px) {
      const float disparity_px = DisparityFromNumber(
          message.values[static_cast<std::size_t>(v) * static_cast<std::size_t>(message.width) +
                         static_cast<std::size_t>(u)]);
      if (!std::isfinite(disparity_px) || disparity_px <= 0.0F) continue;
      const double z = message.fx * message.baseline_m / static_cast<double>(disparity_px);
      if (0.25 * z * z > kMaxSigma_m * message.fx * message.baseline_m) continue;
      const Eigen::Vector3d p_left((u - message.cx) / message.fx * z, (v - message.cy) / message.fy * z, z);
      const Eigen::Vector3d p_world = *T_world_left * p_left;
      if (query != nullptr && IsOnARegion(p_world, 0.0, *query)) continue;
      const Eigen::Vector3d units = (p_world - camera_world) / kUnit_m;
      if (units.cwiseAbs().maxCoeff() > std::numeric_limits<std::int16_t>::max()) continue;
      for (int axis = 0; axis < 3; ++axis)
        AppendBytes(static_cast<std::int16_t>(std::lround(units[axis])), &content);
    }
  }
  return MakeViewRecord(ViewRecordKind::kPoints, Timestamp::FromMicroseconds(message.utime), t_heard,
                        content.data(), content.size());
}

}  // namespace terrace
