// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

#include <opencv2/core/mat.hpp>
#include <terrace/footstep_plan_v1_t.hpp>

#include "tools/surface_raster.h"

namespace terrace {

/// The soles of a plan on the ground (left red, right blue), joined in their order.
/// @param shows  whether a region is what is seen at a pixel of the image; soles on others are hollow
void DrawSoles(cv::Mat3b& image, const Projection& projection, const footstep_plan_v1_t& plan,
               const std::function<bool(const cv::Point& pixel, std::int64_t region_id)>& shows);

}  // namespace terrace
