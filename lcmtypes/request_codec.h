// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>
#include <terrace/disparity_v1_t.hpp>
#include <terrace/terrain_request_v1_t.hpp>

#include "core/camera.h"
#include "core/terrain_request.h"
#include "core/time.h"

namespace terrace {

terrain_request_v1_t ToMessage(const TerrainRequest& request);
/// None when a value cannot be meant: another kind, a number that is not finite, a box turned inside out.
std::optional<TerrainRequest> FromMessage(const terrain_request_v1_t& message);

/// A disparity image as messages carry it, without its pixels.
disparity_v1_t DisparityHead(const StereoCamera& camera, Timestamp t_capture,
                             const std::optional<Eigen::Isometry3d>& T_world_left);
/// Of one pixel; NaN is unknown, and so is what the message has no number for.
std::int16_t DisparityNumber(float disparity_px);
/// [px]; NaN: unknown.
float DisparityFromNumber(std::int16_t number);

}  // namespace terrace
