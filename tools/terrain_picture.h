// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include "core/camera.h"
#include "core/terrain_map.h"
#include "results/replay_result.h"

namespace terrace {

/// The labelled regions over a rectified left image that was taken at T_world_left, with a legend below.
cv::Mat3b DrawFrame(const TerrainMap& map, const cv::Mat1b& left, const StereoCamera& camera,
                    const Eigen::Isometry3d& T_world_left);

/// The whole map: an oblique view, the plan and a side view, with the trajectory, scales and a legend.
cv::Mat3b DrawMap(const ReplayResult& result);

}  // namespace terrace
