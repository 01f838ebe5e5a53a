// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "client/flat_polygon.h"
#include "client/inset.h"
#include "core/terrain_map.h"

namespace terrace {

/// The geometry of one revision of a region, ready to be asked: in its plane, about its centroid, in the axes
/// of AxesOf(normal). Insets are made once each, when they are first asked for. May be asked from any thread.
class RegionShape {
 public:
  explicit RegionShape(const TerrainRegion& region);

  const FlatPolygon& polygon() const { return polygon_; }
  const Eigen::AlignedBox3d& box_world() const { return box_world_; }
  const Eigen::Vector3d& normal_world() const { return normal_; }
  const RegionEdge& edge(std::size_t i) const { return edges_[i]; }

  Eigen::Vector2d ToPlane(const Eigen::Vector3d& point_world) const {
    const Eigen::Vector3d d = point_world - centroid_;
    return {axes_.x.dot(d), axes_.y.dot(d)};
  }
  Eigen::Vector3d ToWorld(const Eigen::Vector2d& flat) const {
    return centroid_ + flat.x() * axes_.x + flat.y() * axes_.y;
  }
  const PlaneAxes& axes_world() const { return axes_; }
  const Eigen::Vector3d& centroid_world() const { return centroid_; }

  /// Height of the plane over (x, y). Only for what faces up: see carries().
  double HeightAt(const Eigen::Vector2d& xy) const {
    return centroid_.z() -
           (normal_.x() * (xy.x() - centroid_.x()) + normal_.y() * (xy.y() - centroid_.y())) / normal_.z();
  }
  /// Standard deviation along z of the plane's height at a point of it; NaN: not known.
  double SigmaHeight(const Eigen::Vector2d& flat) const;
  /// Whether it faces up enough (60 deg) to be the ground under something.
  bool carries() const { return normal_.z() > 0.5; }

  /// Where a foot's middle may stand: the polygon less what is nearer to an edge than the margins, by at most
  /// 1 mm more and never less.
  std::shared_ptr<const FlatPolygon> Inset(const EdgeMargins& margins) const;

 private:
  Eigen::Vector3d normal_;
  Eigen::Vector3d centroid_;
  PlaneAxes axes_;
  Eigen::Matrix3d covariance_;
  FlatPolygon polygon_;
  std::vector<RegionEdge> edges_;
  Eigen::AlignedBox3d box_world_;
  mutable std::mutex mutex_;
  mutable std::map<EdgeMargins, std::shared_ptr<const FlatPolygon>> insets_;
};
using RegionShapePtr = std::shared_ptr<const RegionShape>;

}  // namespace terrace
