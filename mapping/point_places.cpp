// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/point_places.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/point_places.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef TERRACE_MAPPING_POINT_PLACES_ONCE_
#define TERRACE_MAPPING_POINT_PLACES_ONCE_
namespace terrace {

/// What is asked of points, in columns.
struct PointColumns {
  PlacedPoints::Column<float> x, y, z, sigma_depth;  // m, left frame
};

}  // namespace terrace
#endif

HWY_BEFORE_NAMESPACE();
namespace terrace {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using PlaceLanes = hn::CappedTag<float, 16>;
using PlaceInts = hn::RebindToSigned<PlaceLanes>;

/// One axis of the world.
struct Along {
  hn::Vec<PlaceInts> key;        // of the leaf's lowest corner
  hn::Vec<PlaceLanes> offset_m;  // from the leaf's centre
};

/// @param p  from the corner of the camera's leaf, in finest leaves
/// @param size  of the leaf that is sought, in finest leaves
HWY_INLINE Along AlongAxis(hn::Vec<PlaceLanes> p, hn::Vec<PlaceInts> size, int camera_leaf, float leaf_m) {
  const PlaceLanes d;
  const PlaceInts di;
  const auto towards_zero = hn::ConvertTo(di, p);
  const auto above = hn::Gt(hn::ConvertTo(d, towards_zero), p);
  const auto floor = hn::Add(towards_zero, hn::BitCast(di, hn::VecFromMask(d, above)));
  const auto finest = hn::Add(floor, hn::Set(di, camera_leaf));
  const auto corner = hn::And(finest, hn::Neg(size));
  const auto half = hn::Mul(hn::Set(d, 0.5F), hn::ConvertTo(d, size));
  const auto in_finest = hn::Sub(p, hn::ConvertTo(d, floor));
  const auto offset = hn::Add(hn::Sub(in_finest, half), hn::ConvertTo(d, hn::Sub(finest, corner)));
  return {hn::And(hn::Add(corner, hn::Set(di, kKeyOffset)), hn::Set(di, 0xFFFF)),
          hn::Mul(offset, hn::Set(d, leaf_m))};
}

void PlaceColumns(const PointColumns& points, const PointPlacer::Frame& frame, std::size_t count,
                  PlacedPoints* placed) {
  const PlaceLanes d;
  const PlaceInts di;
  const hn::RebindToUnsigned<PlaceLanes> du;
  const auto zero = hn::Zero(d);
  const auto reach = hn::Set(d, static_cast<float>(kMaxReachLeaves));
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto x = hn::LoadU(d, points.x.data() + i), y = hn::LoadU(d, points.y.data() + i),
               z = hn::LoadU(d, points.z.data() + i);
    const auto in_leaves = [&](int axis) HWY_ATTR {
      const auto turned = [&](int column, hn::Vec<PlaceLanes> value) HWY_ATTR {
        return hn::Mul(hn::Set(d, frame.R_leaves_left(axis, column)), value);
      };
      return hn::Add(hn::Add(hn::Add(turned(0, x), turned(1, y)), turned(2, z)),
                     hn::Set(d, frame.in_camera_leaf[axis]));
    };
    const auto px = in_leaves(0), py = in_leaves(1), pz = in_leaves(2);
    const auto sigma = hn::Mul(hn::Set(d, frame.sigma_factor), hn::LoadU(d, points.sigma_depth.data() + i));
    const auto variance = hn::Add(hn::Mul(sigma, sigma), hn::Set(d, frame.pose_variance_m2));
    // Each comparison is false for what is not a number.
    const auto within = [&](hn::Vec<PlaceLanes> p) HWY_ATTR { return hn::Lt(hn::Abs(p), reach); };
    const auto good = hn::And(hn::And(hn::Gt(z, zero), hn::Gt(variance, zero)),
                              hn::And(within(px), hn::And(within(py), within(pz))));
    auto level = hn::Zero(di);
    for (int l = 0; l < frame.coarsest_level; ++l)
      level = hn::Sub(
          level, hn::BitCast(di, hn::VecFromMask(
                                     d, hn::Gt(z, hn::Set(d, frame.max_z_m[static_cast<std::size_t>(l)])))));
    const auto size = hn::Shl(hn::Set(di, 1), level);
    const auto axis = [&](hn::Vec<PlaceLanes> p, int a) HWY_ATTR {
      return AlongAxis(hn::IfThenElseZero(good, p), size, frame.camera_leaf[a], frame.leaf_m);
    };
    const Along ax = axis(px, 0), ay = axis(py, 1), az = axis(pz, 2);
    hn::StoreU(hn::BitCast(du, hn::Or(hn::ShiftLeft<16>(level), ax.key)), du, placed->level_and_x.data() + i);
    hn::StoreU(hn::BitCast(du, hn::Or(hn::ShiftLeft<16>(ay.key), az.key)), du, placed->y_and_z.data() + i);
    hn::StoreU(ax.offset_m, d, placed->x_m.data() + i);
    hn::StoreU(ay.offset_m, d, placed->y_m.data() + i);
    hn::StoreU(az.offset_m, d, placed->z_m.data() + i);
    const auto one = hn::Set(d, 1.0F);
    hn::StoreU(hn::IfThenElseZero(good, hn::Div(one, hn::IfThenElse(good, variance, one))), d,
               placed->weight.data() + i);
    hn::StoreU(hn::Div(hn::Set(d, frame.fb_px_m), hn::IfThenElse(good, z, one)), d,
               placed->disparity_px.data() + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace terrace
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace {
HWY_EXPORT(PlaceColumns);

PointPlacer::PointPlacer(const StereoCamera& camera, const Eigen::Isometry3d& T_world_left,
                         const MappingConfig& config) {
  // In units of the finest leaf; the camera's own leaf is split off, so that floats suffice for what is left.
  const double leaves_per_m = 1.0 / config.leaf_size_m;
  const Eigen::Vector3d camera_in_leaves = T_world_left.translation() * leaves_per_m;
  frame_.camera_leaf = camera_in_leaves.array().floor().cast<int>();
  frame_.in_camera_leaf = (camera_in_leaves - frame_.camera_leaf.cast<double>()).cast<float>();
  frame_.R_leaves_left = (T_world_left.linear() * leaves_per_m).cast<float>();
  frame_.leaf_m = static_cast<float>(config.leaf_size_m);
  frame_.sigma_factor = static_cast<float>(config.depth_sigma_factor);
  frame_.pose_variance_m2 = static_cast<float>(config.pose_sigma_m * config.pose_sigma_m);
  frame_.fb_px_m = static_cast<float>(camera.fx * camera.baseline_m);
  frame_.coarsest_level = CoarsestLevel(config.leaves_per_cell);
  for (int level = 0; level < frame_.coarsest_level; ++level)
    frame_.max_z_m[static_cast<std::size_t>(level)] =
        static_cast<float>(config.leaf_size_m * (1 << level) * camera.fx / config.min_leaf_px);
}

void PointPlacer::Place(const CloudPoint* points, std::size_t count, PlacedPoints* placed) const {
  PointColumns columns;
  for (std::size_t i = 0; i < count; ++i) {
    columns.x[i] = points[i].p_left.x();
    columns.y[i] = points[i].p_left.y();
    columns.z[i] = points[i].p_left.z();
    columns.sigma_depth[i] = points[i].sigma_depth_m;
  }
  // Whole vectors are read.
  for (std::size_t i = count; i < PlacedPoints::kMost; ++i)
    columns.x[i] = columns.y[i] = columns.z[i] = columns.sigma_depth[i] = 0.0F;
  HWY_DYNAMIC_DISPATCH(PlaceColumns)(columns, frame_, count, placed);
}

}  // namespace terrace
#endif
