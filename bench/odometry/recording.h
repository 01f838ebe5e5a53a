// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "odometry/odometry_config.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// A sequence in memory, rectified.
struct Recording {
  std::string name;
  StereoCamera camera;
  Mounting mounting;
  std::vector<StereoFrame> frames;  ///< without images: unreadable
  std::vector<SensorSamples> samples;
  std::map<std::int64_t, Eigen::Isometry3d> truth;  ///< of the rectified left camera, by microseconds
};

Recording LoadRecording(const std::filesystem::path& path);

/// Every nth frame, with all samples between them.
Recording EveryNth(const Recording& recording, int n);

/// Played to its end and then back to the first frame: without samples on the way back, since no sensor
/// measures backwards.
Recording ThereAndBack(const Recording& recording);

}  // namespace terrace
