// SPDX-License-Identifier: BSD-3-Clause
#include "client/box_section.h"

#include <algorithm>
#include <optional>

#include "client/convex_ring.h"

namespace terrace {
namespace {

/// Slab test (Kay and Kajiya, 1986) of the segment from a to b.
bool Meets(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double along = b[axis] - a[axis];
    if (along == 0.0) {
      if (a[axis] < box.min()[axis] || a[axis] > box.max()[axis]) return false;
      continue;
    }
    const double s = (box.min()[axis] - a[axis]) / along;
    const double t = (box.max()[axis] - a[axis]) / along;
    enter = std::max(enter, std::min(s, t));
    leave = std::min(leave, std::max(s, t));
  }
  return enter <= leave;
}

/// Some point that the box and the plane share.
std::optional<Eigen::Vector3d> SharedPoint(const RegionShape& shape, const Eigen::AlignedBox3d& box) {
  // The corners that lie furthest along the normal and against it.
  const Eigen::Vector3d& n = shape.normal_world();
  const Eigen::Vector3d far = (n.array() > 0.0).select(box.max(), box.min());
  const Eigen::Vector3d near = (n.array() > 0.0).select(box.min(), box.max());
  const double above = n.dot(far - shape.centroid_world());
  const double below = n.dot(near - shape.centroid_world());
  if (above < 0.0 || below > 0.0) return std::nullopt;
  const double t = above > below ? -below / (above - below) : 0.0;
  return near + t * (far - near);
}

}  // namespace

bool ReachesInto(const RegionShape& shape, const Eigen::AlignedBox3d& box_world) {
  // Where the plane cuts the box is one convex piece: no edge of the region in it, and it is wholly inside
  // the region or wholly outside.
  const auto shared = SharedPoint(shape, box_world);
  if (!shared) return false;
  if (shape.polygon().Contains(shape.ToPlane(*shared))) return true;
  for (std::size_t i = 0; i < shape.polygon().num_edges(); ++i) {
    if (Meets(box_world, shape.ToWorld(shape.polygon().start(i)), shape.ToWorld(shape.polygon().end(i))))
      return true;
  }
  return false;
}

FlatRing SectionOf(const RegionShape& shape, const Eigen::AlignedBox3d& box_world) {
  FlatRing ring = RingOf(shape.polygon().box());
  const PlaneAxes& axes = shape.axes_world();
  const Eigen::Vector3d& origin = shape.centroid_world();
  for (int axis = 0; axis < 3 && !ring.empty(); ++axis) {
    const Eigen::Vector2d along(axes.x[axis], axes.y[axis]);
    ring = Cut(ring, along, box_world.max()[axis] - origin[axis]);
    if (!ring.empty()) ring = Cut(ring, -along, origin[axis] - box_world.min()[axis]);
  }
  return ring;
}

}  // namespace terrace
