// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/edge_kinds.h"

#include <algorithm>
#include <cmath>

#include "core/plane_rings.h"
#include "labeling/drop_view.h"

namespace terrace {
namespace {

/// Heights that differ by less are the same.
constexpr double kSameHeight = 0.05;
/// Farther away ground may end in the image because too little of it is matched.
constexpr double kFarthestEnd = 3.0;
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

/// What an upright face beside the edge makes of it. Its top is the height beyond a rise when it was in view;
/// how deep a drop is the face does not tell, for its foot may be hidden.
RegionEdge EdgeAtFace(const RegionShape& self, const RegionShape& face, TopView top,
                      const Eigen::Vector3d& p) {
  constexpr double kTopSigma = 0.01;  // where matching ends at an upper edge
  const FaceColumn* column = ColumnBeside(face, p);
  if (!column) return {};
  if (column->top_m > p.z() + kSameHeight && column->bottom_m < p.z() + 2.0 * kSameHeight) {
    if (top != TopView::kSeen) return {EdgeKind::kRise, {}, {}};
    return {EdgeKind::kRise, column->top_m - p.z(), std::hypot(kTopSigma, HeightSigma(self, p.head<2>()))};
  }
  if (column->top_m > p.z() - 2.0 * kSameHeight && column->bottom_m < p.z() - kSameHeight)
    return {EdgeKind::kDrop, {}, {}};
  return {};
}

RegionEdge EdgeBeside(const RegionShape& self, const RegionShape& other, TopView top,
                      const Eigen::Vector3d& p) {
  if (!Near(other.bounds, p)) return {};
  if (other.lean == Lean::kUpright) return EdgeAtFace(self, other, top, p);
  // Heights are quicker to compare than outlines. What is higher is no drop, and no rise without a face.
  if (other.lean != Lean::kSupport || other.HeightAt(p.head<2>()) - p.z() > kSameHeight + kPlaneSlack)
    return {};
  Eigen::Vector2d q;
  if (other.PlanDistance(p.head<2>(), &q) > kEdgeReach) return {};
  const double height = other.HeightAt(q) - p.z();
  if (height > kSameHeight) return {};
  return {height < -kSameHeight ? EdgeKind::kDrop : EdgeKind::kJoins, height,
          std::hypot(HeightSigma(self, p.head<2>()), HeightSigma(other, q))};
}

/// Of two things beyond one edge the one that matters more to a foot; of two alike the one of which the step
/// is known, of those the greater drop or rise.
RegionEdge Stronger(const RegionEdge& a, const RegionEdge& b) {
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
  if (rank(a.kind) != rank(b.kind)) return rank(a.kind) > rank(b.kind) ? a : b;
  if (!a.step_m || !b.step_m) return a.step_m ? a : b;
  return std::abs(*a.step_m) >= std::abs(*b.step_m) ? a : b;
}

/// Steps are told to the millimetre: less is no change.
RegionEdge InMillimetres(RegionEdge edge) {
  const auto rounded = [](double value_m) { return std::round(1e3 * value_m) / 1e3; };
  if (edge.step_m) edge.step_m = rounded(*edge.step_m);
  if (edge.sigma_m) edge.sigma_m = std::max(1e-3, rounded(*edge.sigma_m));
  return edge;
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

std::vector<RegionEdge> EdgesOf(int i, const std::vector<RegionShapePtr>& shapes,
                                const std::vector<TopView>& tops, const Eigen::Matrix3d& R_level_world,
                                const Eigen::Vector3d& eye) {
  const RegionShape& self = *shapes[i];
  const bool ground = self.lean == Lean::kSupport;
  const Eigen::Vector3d reach(kEdgeReach, kEdgeReach, 3.0 * kEdgeReach);
  const Eigen::AlignedBox3d wide(self.bounds.min() - reach, self.bounds.max() + reach);
  std::vector<int> beside;
  std::vector<const RegionShape*> lower;
  for (int j = 0; j < static_cast<int>(shapes.size()); ++j) {
    if (j == i) continue;
    if (wide.intersects(shapes[j]->bounds)) beside.push_back(j);
    if (ground && shapes[j]->bounds.min().z() < self.bounds.max().z() - kMinDrop)
      lower.push_back(shapes[j].get());
  }
  const std::vector<bool>& seen_past = self.polygon->seen_past;
  const auto beyond = [&](const Eigen::Vector3d& p, const Eigen::Vector2d& outward, std::size_t edge_index) {
    RegionEdge edge;
    for (const int j : beside) {
      if (edge.kind == EdgeKind::kRise && edge.step_m) break;  // nothing is stronger
      edge = Stronger(edge, ground ? EdgeBeside(self, *shapes[j], tops[j], p)
                                   : RegionEdge{KindOfFaceEdge(*shapes[j], p), {}, {}});
    }
    const bool look_over = ground && (edge.kind == EdgeKind::kLimitOfView || edge.kind == EdgeKind::kDrop);
    if (!look_over || edge.step_m) return edge;
    // Where one looks past the ground it ends, however far down it goes there.
    const bool is_near = (p - eye).norm() < kFarthestEnd;
    if (is_near && edge_index < seen_past.size() && seen_past[edge_index]) edge.kind = EdgeKind::kDrop;
    if (lower.empty()) return edge;
    return DropSeenOver(p, outward, eye, self, lower).value_or(edge);
  };

  std::vector<RegionEdge> edges;
  const auto add = [&](const Ring& ring) {
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Eigen::Vector3d a = R_level_world * ring[k], b = R_level_world * ring[(k + 1) % ring.size()];
      // Outlines run counter-clockwise about the ground, holes clockwise: it lies on the left.
      const Eigen::Vector2d outward = -LeftOf((b - a).head<2>().normalized());
      edges.push_back(InMillimetres(beyond(0.5 * (a + b), outward, edges.size())));
    }
  };
  add(self.polygon->outline_world);
  for (const Ring& hole : self.polygon->holes_world) add(hole);
  return edges;
}

void KeepKnownDrops(const TerrainRegion& before, const Polygon& now, std::vector<RegionEdge>& edges) {
  struct Drop {
    Eigen::Vector3d a, b;
    RegionEdge edge;
  };
  std::vector<Drop> drops;
  std::size_t next = 0;
  const auto collect = [&](const Ring& ring) {
    for (std::size_t k = 0; k < ring.size() && next < before.edges.size(); ++k, ++next)
      if (before.edges[next].kind == EdgeKind::kDrop)
        drops.push_back({ring[k], ring[(k + 1) % ring.size()], before.edges[next]});
  };
  collect(before.outline_world);
  for (const Ring& hole : before.holes_world) collect(hole);
  if (drops.empty()) return;

  std::size_t e = 0;
  const auto keep = [&](const Ring& ring) {
    for (std::size_t k = 0; k < ring.size() && e < edges.size(); ++k, ++e) {
      if (edges[e].kind != EdgeKind::kLimitOfView) continue;
      const Eigen::Vector3d p = 0.5 * (ring[k] + ring[(k + 1) % ring.size()]);
      for (const Drop& drop : drops) {
        constexpr double kSameEdge = 0.05;
        if ((NearestOnSegment(drop.a, drop.b, p) - p).norm() <= kSameEdge) edges[e] = drop.edge;
      }
    }
  };
  keep(now.outline_world);
  for (const Ring& hole : now.holes_world) keep(hole);
}

}  // namespace terrace
