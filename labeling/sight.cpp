// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/sight.h"

namespace terrace {

bool Sight::InView(const Eigen::Vector3d& p_level) const {
  if (camera.width <= 0) return true;
  constexpr double kBorder_px = 10.0;  // matching leaves the border of the image empty
  constexpr double kMinDepth = 0.1;
  const Eigen::Vector3d p = T_level_left.inverse() * p_level;
  if (p.z() < kMinDepth) return false;
  const Eigen::Vector2d pixel = camera.Project(p);
  return pixel.x() >= kBorder_px && pixel.x() <= camera.width - 1 - kBorder_px && pixel.y() >= kBorder_px &&
         pixel.y() <= camera.height - 1 - kBorder_px;
}

}  // namespace terrace
