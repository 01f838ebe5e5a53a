// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/view_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrace {
namespace {

/// Distance of a point from the piece itself; of one that leans, its plan is searched, which is exact inside.
double DistanceTo(const RegionShape& shape, const Eigen::Vector3d& p) {
  if (shape.lean == Lean::kUpright) {
    double least = std::numeric_limits<double>::infinity();
    for (const FaceColumn& column : shape.columns) {
      const double z = std::clamp(p.z(), column.bottom_m, column.top_m);
      least = std::min(least, (shape.FacePoint(column.along_m, z) - p).norm());
    }
    return least;
  }
  const Eigen::Vector3d foot = shape.plane.Project(p);
  Eigen::Vector2d q;
  if (shape.PlanDistance(foot.head<2>(), &q) <= 0.0) return (foot - p).norm();
  return (Eigen::Vector3d(q.x(), q.y(), shape.HeightAt(q)) - p).norm();
}

}  // namespace

void ViewMemory::JudgeTop(const RegionShape& face, const Eigen::Isometry3d& T_left_level,
                          Memory& memory) const {
  if (camera_.width <= 0 || face.columns.empty()) return;
  constexpr double kAbove = 0.10;      // what should show above a top that is one
  constexpr double kBorder_px = 10.0;  // matching leaves the border of the image empty
  constexpr double kMinDepth = 0.3;
  constexpr int kMaxSamples = 8;
  constexpr double kGrown = 0.05;
  constexpr int kLongSeen = 5;  // frames
  if (face.heights().high > memory.top_m + kGrown) {
    // What was seen was no top. What was cut off went on, and may go on: its top must be seen for some time.
    memory.top_m = face.heights().high;
    memory.num_seen = 0;
    memory.num_cut = std::min(memory.num_cut, kLongSeen);
  }
  const Eigen::Vector3d eye = T_left_level.inverse().translation();
  if (face.plane.SignedDistance(eye) <= 0.0) return;
  const int n = static_cast<int>(face.columns.size());
  const int stride = std::max(1, (n + kMaxSamples - 1) / kMaxSamples);
  int seen = 0, cut = 0;
  for (int c = stride / 2; c < n; c += stride) {
    const FaceColumn& column = face.columns[c];
    if (!face.ReachesUpperHalf(column)) continue;
    const Eigen::Vector3d p = T_left_level * face.FacePoint(column.along_m, column.top_m + kAbove);
    if (p.z() < kMinDepth || p.z() > max_depth_m_) continue;
    const Eigen::Vector2d pixel = camera_.Project(p);
    if (pixel.x() < kBorder_px || pixel.x() > camera_.width - 1 - kBorder_px) continue;
    if (pixel.y() > camera_.height - 1) continue;
    ++(pixel.y() < kBorder_px ? cut : seen);
  }
  if (seen + cut == 0) return;
  ++(seen > cut ? memory.num_seen : memory.num_cut);
}

void ViewMemory::Look(const ShapeTable& table, const Eigen::Isometry3d& T_level_left, Timestamp t_now) {
  const Eigen::Isometry3d T_left_level = T_level_left.inverse();
  tops_.clear();
  nearest_view_m_.clear();
  for (const RegionShapePtr& shape : table.shapes()) {
    const auto [entry, fresh] = memories_.try_emplace(shape->id());
    Memory& memory = entry->second;
    if (fresh || shape->polygon->last_seen >= t_now) {
      const Eigen::Vector3d eye = T_level_left.translation();
      // What a box around it says is quick to find, and never more.
      const double at_least = std::sqrt(shape->bounds.squaredExteriorDistance(eye));
      if (fresh) memory.nearest_m = std::numeric_limits<double>::infinity();
      if (at_least < memory.nearest_m) memory.nearest_m = std::min(memory.nearest_m, DistanceTo(*shape, eye));
      if (shape->lean == Lean::kUpright) JudgeTop(*shape, T_left_level, memory);
    }
    tops_.push_back(memory.num_seen + memory.num_cut == 0 ? TopView::kNotJudged
                    : memory.num_seen >= memory.num_cut   ? TopView::kSeen
                                                          : TopView::kOutOfView);
    nearest_view_m_.push_back(memory.nearest_m);
  }
  // Ids are never used again, so that there is no hurry.
  constexpr std::size_t kMaxGone = 64;
  if (memories_.size() > table.size() + kMaxGone)
    std::erase_if(memories_, [&](const auto& entry) { return table.Find(entry.first) == nullptr; });
}

}  // namespace terrace
