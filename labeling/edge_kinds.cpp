// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/edge_kinds.h"

#include <algorithm>
#include <cmath>

namespace terrace {
namespace {

/// Heights that differ by less are the same.
constexpr double kSameHeight = 0.05;
/// By how much a walkable plane may rise or fall within kEdgeReach.
constexpr double kPlaneSlack = 0.06;

bool Near(const Eigen::AlignedBox3d& bounds, const Eigen::Vector3d& p) {
  const Eigen::Vector3d outside = (bounds.min() - p).cwiseMax(p - bounds.max());
  return outside.head<2>().maxCoeff() <= kEdgeReach;
}

/// The nearest height span of an upright face beside p; none when it is too far away.
const FaceColumn* ColumnBeside(const RegionShape& face, const Eigen::Vector3d& p) {
  const double along = face.face_axis.dot(p.head<2>());
  const auto after = std::lower_bound(face.columns.begin(), face.columns.end(), along,
                                      [](const FaceColumn& c, double a) { return c.along_m < a; });
  const FaceColumn* nearest = nullptr;
  if (after != face.columns.end()) nearest = &*after;
  if (after != face.columns.begin() &&
      (!nearest || along - std::prev(after)->along_m < nearest->along_m - along))
    nearest = &*std::prev(after);
  if (!nearest || std::abs(nearest->along_m - along) > kEdgeReach) return nullptr;
  const double z = std::clamp(p.z(), nearest->bottom_m, nearest->top_m);
  const double across = (face.FacePoint(along, z).head<2>() - p.head<2>()).norm();
  return across <= kEdgeReach ? nearest : nullptr;
}

EdgeKind KindBeside(const RegionShape& other, const Eigen::Vector3d& p) {
  if (!Near(other.bounds, p)) return EdgeKind::kLimitOfView;
  if (other.lean == Lean::kUpright) {
    const FaceColumn* column = ColumnBeside(other, p);
    if (!column) return EdgeKind::kLimitOfView;
    if (column->top_m > p.z() + kSameHeight && column->bottom_m < p.z() + 2.0 * kSameHeight)
      return EdgeKind::kRise;
    if (column->top_m > p.z() - 2.0 * kSameHeight && column->bottom_m < p.z() - kSameHeight)
      return EdgeKind::kDrop;
    return EdgeKind::kLimitOfView;
  }
  // Heights are quicker to compare than outlines. What is higher is no drop, and no rise without a face.
  if (other.lean != Lean::kSupport || other.HeightAt(p.head<2>()) - p.z() > kSameHeight + kPlaneSlack)
    return EdgeKind::kLimitOfView;
  Eigen::Vector2d q;
  if (other.PlanDistance(p.head<2>(), &q) > kEdgeReach) return EdgeKind::kLimitOfView;
  const double height = other.HeightAt(q) - p.z();
  if (std::abs(height) <= kSameHeight) return EdgeKind::kJoins;
  return height < 0.0 ? EdgeKind::kDrop : EdgeKind::kLimitOfView;
}

/// Of two kinds on one edge the one that matters more to a foot.
EdgeKind Stronger(EdgeKind a, EdgeKind b) {
  const auto rank = [](EdgeKind kind) {
    switch (kind) {
      case EdgeKind::kLimitOfView:
        return 0;
      case EdgeKind::kDrop:
        return 1;
      case EdgeKind::kJoins:
        return 2;
      case EdgeKind::kRise:
        return 3;
    }
    return 0;
  };
  return rank(a) >= rank(b) ? a : b;
}

/// Upright faces only say where they go on: drop and rise are words of the ground.
EdgeKind KindOfFaceEdge(const RegionShape& other, const Eigen::Vector3d& p) {
  if (!Near(other.bounds, p)) return EdgeKind::kLimitOfView;
  if (other.lean == Lean::kUpright) {
    const FaceColumn* column = ColumnBeside(other, p);
    const bool beside = column && p.z() > column->bottom_m - kEdgeReach && p.z() < column->top_m + kEdgeReach;
    return beside ? EdgeKind::kJoins : EdgeKind::kLimitOfView;
  }
  if (other.lean != Lean::kSupport ||
      std::abs(other.HeightAt(p.head<2>()) - p.z()) > kEdgeReach + kPlaneSlack)
    return EdgeKind::kLimitOfView;
  Eigen::Vector2d q;
  if (other.PlanDistance(p.head<2>(), &q) > kEdgeReach) return EdgeKind::kLimitOfView;
  return std::abs(other.HeightAt(q) - p.z()) <= kEdgeReach ? EdgeKind::kJoins : EdgeKind::kLimitOfView;
}

}  // namespace

std::vector<RegionEdge> EdgeKindsOf(int i, const std::vector<RegionShapePtr>& shapes,
                                    const Eigen::Matrix3d& R_level_world) {
  const RegionShape& self = *shapes[i];
  const Eigen::Vector3d reach(kEdgeReach, kEdgeReach, 3.0 * kEdgeReach);
  const Eigen::AlignedBox3d wide(self.bounds.min() - reach, self.bounds.max() + reach);
  std::vector<const RegionShape*> others;
  for (int j = 0; j < static_cast<int>(shapes.size()); ++j)
    if (j != i && wide.intersects(shapes[j]->bounds)) others.push_back(shapes[j].get());

  std::vector<RegionEdge> edges;
  const auto add = [&](const Ring& ring) {
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Eigen::Vector3d p = R_level_world * (0.5 * (ring[k] + ring[(k + 1) % ring.size()]));
      EdgeKind kind = EdgeKind::kLimitOfView;
      for (const RegionShape* other : others) {
        if (kind == EdgeKind::kRise) break;  // nothing is stronger
        kind =
            Stronger(kind, self.lean == Lean::kSupport ? KindBeside(*other, p) : KindOfFaceEdge(*other, p));
      }
      edges.push_back({kind, {}, {}});
    }
  };
  add(self.polygon->outline_world);
  for (const Ring& hole : self.polygon->holes_world) add(hole);
  return edges;
}

}  // namespace terrace
