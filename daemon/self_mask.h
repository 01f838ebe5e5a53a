// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "core/camera.h"
#include "daemon/pipeline_config.h"

namespace terrace {

/// The image mask of the robot's own parts: 0 where the robot sees itself, of the rectified left image's
/// size. Empty when nothing is configured. Throws ConfigError when the PNG cannot be read or has another size
/// than its pixels say, when parts are given and the body is not known, when the camera is inside one of
/// them, and when nothing is left to see.
cv::Mat1b LoadSelfMask(const PipelineConfig& config, const StereoCalibration& calibration);

/// Hides what a camera sees of parts of its body.
/// @param T_body_left  of the rectified camera
/// @param mask  of its size; what is hidden already stays so
void HideParts(const SelfMaskConfig& parts, const StereoCamera& camera, const Eigen::Isometry3d& T_body_left,
               cv::Mat1b* mask);

}  // namespace terrace
