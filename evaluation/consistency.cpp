// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/consistency.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "datasets/sequence.h"
#include "evaluation/statistics.h"

namespace terrace {
namespace {

/// Neighbouring pixels say the same: every fourth of every fourth row is enough.
constexpr int kPixelStep = 4;
constexpr double kOff_px = 1.0;

double Grey(const GrayImage& image, int u, int v) {
  return image.data[static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                    static_cast<std::size_t>(u)];
}

}  // namespace

void ConsistencyMeter::Add(const FloatImage& disparity_px, const StereoPair* pair,
                           const std::optional<Eigen::Isometry3d>& T_world_left) {
  ++num_images_;
  num_pixels_ += static_cast<std::int64_t>(disparity_px.data.size());
  num_values_ += std::count_if(disparity_px.data.begin(), disparity_px.data.end(),
                               [](float d) { return !std::isnan(d); });
  if (pair != nullptr) AddPhotometric(disparity_px, *pair);
  if (T_world_left && T_world_last_) AddTemporal(disparity_px, *T_world_left);
  last_px_ = disparity_px;
  T_world_last_ = T_world_left;
}

void ConsistencyMeter::AddPhotometric(const FloatImage& disparity_px, const StereoPair& pair) {
  std::vector<std::pair<double, double>> greys;  // left, right
  double sum_left = 0.0, sum_right = 0.0;
  for (int v = 0; v < disparity_px.height; v += kPixelStep) {
    for (int u = 0; u < disparity_px.width; u += kPixelStep) {
      const double x = u - static_cast<double>(disparity_px.At(u, v));
      if (!(x >= 0.0)) continue;
      const int column = std::min(static_cast<int>(x), pair.right.width - 2);
      const double share = x - column;
      const double right =
          (1.0 - share) * Grey(pair.right, column, v) + share * Grey(pair.right, column + 1, v);
      greys.emplace_back(Grey(pair.left, u, v), right);
      sum_left += greys.back().first;
      sum_right += right;
    }
  }
  const double gain = sum_right > 0.0 ? sum_left / sum_right : 1.0;
  for (const auto& [left, right] : greys) grey_.push_back(std::abs(left - gain * right));
}

void ConsistencyMeter::AddTemporal(const FloatImage& disparity_px, const Eigen::Isometry3d& T_world_left) {
  const Eigen::Isometry3d T_now_last = T_world_left.inverse() * *T_world_last_;
  for (int v = 0; v < last_px_.height; v += kPixelStep) {
    for (int u = 0; u < last_px_.width; u += kPixelStep) {
      const double d = last_px_.At(u, v);
      if (!(d > 0.0)) continue;
      const double depth_m = camera_.Depth(d);
      const Eigen::Vector3d p = T_now_last * (depth_m * Eigen::Vector3d((u - camera_.cx) / camera_.fx,
                                                                        (v - camera_.cy) / camera_.fy, 1.0));
      if (p.z() <= 0.0) continue;
      const double column = std::round(camera_.fx * p.x() / p.z() + camera_.cx);
      const double row = std::round(camera_.fy * p.y() / p.z() + camera_.cy);
      if (!(column >= 0 && column < disparity_px.width && row >= 0 && row < disparity_px.height)) continue;
      const float now = disparity_px.At(static_cast<int>(column), static_cast<int>(row));
      if (!std::isnan(now)) moved_px_.push_back(std::abs(now - camera_.Disparity(p.z())));
    }
  }
}

DisparityConsistency ConsistencyMeter::Result() const {
  DisparityConsistency result;
  result.num_images = num_images_;
  if (num_pixels_ > 0)
    result.density_pct = 100.0 * static_cast<double>(num_values_) / static_cast<double>(num_pixels_);
  result.num_photometric = static_cast<std::int64_t>(grey_.size());
  result.photometric_median = QuantileOf(grey_, 0.5);
  result.photometric_p90 = QuantileOf(grey_, 0.9);
  result.num_temporal = static_cast<std::int64_t>(moved_px_.size());
  result.temporal_median_px = QuantileOf(moved_px_, 0.5);
  const auto off = std::count_if(moved_px_.begin(), moved_px_.end(), [](double px) { return px > kOff_px; });
  if (!moved_px_.empty())
    result.temporal_off_pct = 100.0 * static_cast<double>(off) / static_cast<double>(moved_px_.size());
  return result;
}

std::optional<DisparityConsistency> EvaluateConsistency(const ReplayResult& result,
                                                        const std::filesystem::path& sequence) {
  const std::map<Timestamp, std::filesystem::path> saved = SavedDisparities(result.folder);
  if (saved.empty()) return std::nullopt;
  std::map<Timestamp, Eigen::Isometry3d> poses;
  for (const ResultPose& pose : result.trajectory) poses[pose.t_capture] = pose.T_world_left;
  ConsistencyMeter meter(result.camera.camera);
  const auto frames = OpenSequence(sequence);
  const bool rectified = frames->info().calibration.rectified();
  while (const std::optional<SensorFrame> frame = frames->Next()) {
    const auto path = saved.find(frame->pair.t_capture);
    if (path == saved.end()) continue;
    const FloatImage disparity_px = ReadDisparityFile(path->second);
    const auto pose = poses.find(frame->pair.t_capture);
    const bool same_size = frame->pair.problem.empty() && frame->pair.right.width == disparity_px.width &&
                           frame->pair.right.height == disparity_px.height;
    meter.Add(disparity_px, rectified && same_size ? &frame->pair : nullptr,
              pose == poses.end() ? std::nullopt : std::optional(pose->second));
  }
  return meter.Result();
}

}  // namespace terrace
