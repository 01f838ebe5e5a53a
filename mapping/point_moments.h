// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include <Eigen/Core>

namespace terrace {

/// Weighted sums over the points of one leaf, from which mean and covariance follow without the points.
/// Points are taken relative to the leaf's centre, so that floats keep enough digits far from the origin.
struct PointMoments {
  float weight = 0.0F;  ///< sum of 1 / variance
  float num_points = 0.0F;
  std::array<float, 3> sum{};        ///< weight * p
  std::array<float, 6> sum_outer{};  ///< weight * p p^T: xx xy xz yy yz zz

  void Add(float w, const Eigen::Vector3f& p) {
    weight += w;
    num_points += 1.0F;
    const float wx = w * p.x(), wy = w * p.y(), wz = w * p.z();
    sum[0] += wx;
    sum[1] += wy;
    sum[2] += wz;
    sum_outer[0] += wx * p.x();
    sum_outer[1] += wx * p.y();
    sum_outer[2] += wx * p.z();
    sum_outer[3] += wy * p.y();
    sum_outer[4] += wy * p.z();
    sum_outer[5] += wz * p.z();
  }
};

}  // namespace terrace
