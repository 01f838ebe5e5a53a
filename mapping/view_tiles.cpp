// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/view_tiles.h"

#include <algorithm>
#include <array>
#include <limits>

namespace terrace {

void ViewTiles::Clear(const StereoCamera& camera) {
  camera_ = camera;
  num_x_ = (camera.width + kTilePx - 1) / kTilePx;
  num_y_ = (camera.height + kTilePx - 1) / kTilePx;
  nearest_px_.assign(static_cast<std::size_t>(num_x_) * num_y_, 0.0F);
}

void ViewTiles::Widen() {
  farthest_px_ = std::numeric_limits<float>::infinity();
  for (const float disparity : nearest_px_)
    if (disparity > 0.0F) farthest_px_ = std::min(farthest_px_, disparity);
  for (int y = 0; y < num_y_; ++y) {
    for (int x = 0; x < num_x_; ++x) {
      float* tile = &nearest_px_[static_cast<std::size_t>(y) * num_x_ + x];
      if (x + 1 >= num_x_ || y + 1 >= num_y_) {
        *tile = 0.0F;
        continue;
      }
      const std::array<float, 4> d{tile[0], tile[1], tile[num_x_], tile[num_x_ + 1]};
      *tile = *std::min_element(d.begin(), d.end()) > 0.0F ? *std::max_element(d.begin(), d.end()) : 0.0F;
    }
  }
}

ViewTiles::View ViewTiles::ViewOf(const Eigen::Vector3f& centre, float radius_m, float margin_px) const {
  if (centre.z() <= radius_m + 0.02F) return View::kNone;
  const float inverse_z = 1.0F / centre.z();
  // The tile whose corner towards its right and lower neighbours is nearest.
  const float u =
      (static_cast<float>(camera_.fx) * centre.x() * inverse_z + static_cast<float>(camera_.cx) + 0.5F) /
          kTilePx -
      0.5F;
  const float v =
      (static_cast<float>(camera_.fy) * centre.y() * inverse_z + static_cast<float>(camera_.cy) + 0.5F) /
          kTilePx -
      0.5F;
  if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(num_x_) && v < static_cast<float>(num_y_)))
    return View::kNone;
  const float nearest = nearest_px_[static_cast<std::size_t>(v) * num_x_ + static_cast<std::size_t>(u)];
  if (nearest == 0.0F) return View::kNone;
  const float fb = static_cast<float>(camera_.fx * camera_.baseline_m);
  if (fb / (centre.z() + radius_m) > nearest + margin_px) return View::kThrough;
  return nearest > fb / (centre.z() - radius_m) + margin_px ? View::kNone : View::kOnto;
}

}  // namespace terrace
