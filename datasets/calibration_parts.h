// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"

namespace terrace {

enum class CameraSide { kUnknown, kLeft, kRight };

/// What a common frame of cameras is.
enum class CommonFrame {
  kCamera,  ///< one of the cameras, or their rectified axes: nothing is known about a body
  kBody,    ///< whatever the file calls body
  kImu,
};

/// What one file says about one camera; what it does not say is empty.
struct CameraPart {
  std::string place;  ///< file and name, for messages
  CameraSide side = CameraSide::kUnknown;
  int width = 0;   ///< 0: not said
  int height = 0;  ///< 0: not said
  std::optional<RawCamera> lens;
  std::optional<Eigen::Isometry3d> T_common_camera;
  CommonFrame common = CommonFrame::kCamera;
};

/// What one file says about a rig.
struct CalibrationParts {
  std::string format;  ///< in words: "Kalibr camchain"
  std::vector<CameraPart> cameras;
  std::optional<Eigen::Isometry3d> T_right_left;
  /// Metres per unit of the lengths in the file; none: it does not say.
  std::optional<double> unit_m = 1.0;
  std::optional<Eigen::Isometry3d> T_common_imu;
  ImuNoise imu_noise;
  /// Time of the IMU less that of the camera, for the same event [s].
  std::optional<double> imu_minus_camera_s;
  std::vector<std::string> notes;  ///< what a user should know, a sentence each
};

}  // namespace terrace
