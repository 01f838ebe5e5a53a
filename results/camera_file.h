// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/camera.h"

namespace terrace {

/// The rectified pair and how it sits on the robot: what camera.json holds.
struct ResultCamera {
  StereoCamera camera;
  Eigen::Matrix3d R_rect_raw = Eigen::Matrix3d::Identity();  ///< p_left = R_rect_raw * p_rawleft
  std::optional<Eigen::Isometry3d> T_body_left;
};

/// The text of the file.
std::string CameraJson(const ResultCamera& camera);
/// Throws FileError (core/file_bytes.h) with the file, the place and the rule that is broken.
ResultCamera ReadCameraFile(const std::filesystem::path& path);

}  // namespace terrace
