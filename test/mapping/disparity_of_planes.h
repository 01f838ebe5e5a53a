// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <random>

#include "stereo/disparity_image.h"
#include "test/mapping/plane_world.h"

namespace terrace {

/// What a stereo camera measures of a world of planes: exact disparities with noise.
inline DisparityImage DisparityOf(const PlaneWorld& world, const StereoCamera& camera,
                                  const PoseEstimate& pose, float sigma_px, std::mt19937* random) {
  std::normal_distribution<float> noise(0.0F, sigma_px);
  DisparityImage image;
  image.frame_id = pose.frame_id;
  image.t_capture = pose.t_capture;
  image.disparity_px = cv::Mat1f(camera.height, camera.width, std::numeric_limits<float>::quiet_NaN());
  image.sigma_px = cv::Mat1f(camera.height, camera.width, sigma_px);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      const double depth = world.Depth(pose.T_world_left.translation(), pose.T_world_left.linear() * ray);
      if (std::isfinite(depth))
        image.disparity_px(v, u) = static_cast<float>(camera.Disparity(depth)) + noise(*random);
    }
  }
  return image;
}

}  // namespace terrace
