// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/window.h"

#include <algorithm>

#include <Eigen/Dense>

namespace terrace {

double Landmark::trust() const {
  constexpr double kOfNew = 0.2;
  constexpr double kPerFrame = 0.1;
  constexpr double kAnyway = 2.0;  // frames: one miss says little
  return std::min(1.0, kOfNew + kPerFrame * num_tracked) * (num_tracked + kAnyway) /
         (num_tracked + num_missed + kAnyway);
}

bool Project(const Landmark& landmark, const Eigen::Isometry3d& T_left_host, const StereoCamera& camera,
             Projection& projection) {
  constexpr double kMinDepthRatio = 0.05;
  constexpr double kMinAreaRatio = 0.02;
  const double fb = camera.fx * camera.baseline_m;
  const Eigen::Matrix3d& R = T_left_host.linear();
  const Eigen::Vector3d t = T_left_host.translation();
  const double w = landmark.inverse_depth;
  const Eigen::Vector3d q = R * landmark.ray_host + w * t;
  if (!(q.z() > kMinDepthRatio)) return false;

  projection.q = q;
  projection.uvd = {camera.fx * q.x() / q.z() + camera.cx, camera.fy * q.y() / q.z() + camera.cy,
                    fb * w / q.z()};
  Eigen::Matrix<double, 2, 3> pixel_by_q;
  pixel_by_q << camera.fx / q.z(), 0, -camera.fx * q.x() / (q.z() * q.z()),  //
      0, camera.fy / q.z(), -camera.fy * q.y() / (q.z() * q.z());
  projection.uvd_by_inverse_depth.head<2>() = pixel_by_q * t;
  projection.uvd_by_inverse_depth.z() = fb / q.z() - fb * w * t.z() / (q.z() * q.z());

  // Along the plane the inverse depth changes with the pixel in the host.
  const Eigen::Vector2d w_by_pixel = landmark.disparity_gradient / fb;
  Eigen::Matrix<double, 3, 2> q_by_pixel;
  q_by_pixel.col(0) = R.col(0) / camera.fx + w_by_pixel.x() * t;
  q_by_pixel.col(1) = R.col(1) / camera.fy + w_by_pixel.y() * t;
  projection.A_here_host = pixel_by_q * q_by_pixel;
  if (!(projection.A_here_host.determinant() > kMinAreaRatio)) return false;
  const Eigen::RowVector2d d_by_pixel =
      fb / q.z() * w_by_pixel.transpose() - fb * w / (q.z() * q.z()) * q_by_pixel.row(2);
  projection.disparity_gradient = (d_by_pixel * projection.A_here_host.inverse()).transpose();
  return true;
}

}  // namespace terrace
