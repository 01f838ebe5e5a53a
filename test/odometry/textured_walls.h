// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "stereo/stereo_frame.h"
#include "test_cameras.h"
#include "textured_image.h"

namespace terrace {

constexpr double kWallDistance_m = 2.4;

/// What a camera sees of an endless wall 2.4 m before it, whose texture has its origin in the optical axis of
/// a camera at zero: along x to the right, along y down [m].
/// @param wall  another number, another wall
inline StereoFrame TexturedWall(const Eigen::Vector2d& camera_m, int wall = 0) {
  const StereoCamera& camera = kVgaCamera;
  const double px_per_m = camera.fx / kWallDistance_m;
  const auto draw = [&](double right_m) {
    cv::Mat1b image(camera.height, camera.width);
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u)
        image(v, u) = cv::saturate_cast<std::uint8_t>(
            Texture(0.5 * (u + px_per_m * (camera_m.x() + right_m)) + 5000.0 * wall,
                    0.5 * (v + px_per_m * camera_m.y())));
    return image;
  };
  StereoFrame frame;
  frame.left = draw(0.0);
  frame.right = draw(camera.baseline_m);
  return frame;
}

}  // namespace terrace
