// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <terrace/footstep_plan_v1_t.hpp>

#include "core/camera.h"
#include "core/terrain_map.h"
#include "results/replay_result.h"

namespace terrace {

/// The labelled regions over a rectified left image that was taken at T_world_left, with a legend below.
/// @param plan  whose soles are drawn on the ground, hollow where something hides them; null: none
cv::Mat3b DrawFrame(const TerrainMap& map, const cv::Mat1b& left, const StereoCamera& camera,
                    const Eigen::Isometry3d& T_world_left, const footstep_plan_v1_t* plan = nullptr);

/// The whole map: an oblique view, the plan and a side view, with the trajectory, scales and a legend.
/// @param plan  likewise
cv::Mat3b DrawMap(const ReplayResult& result, const footstep_plan_v1_t* plan = nullptr);

}  // namespace terrace
