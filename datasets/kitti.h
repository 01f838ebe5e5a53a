// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include <Eigen/Core>

#include "datasets/sequence.h"
#include "datasets/text_table.h"

namespace terrace {

/// Which two of the four KITTI cameras a folder holds, and where the left one is.
struct KittiCameras {
  int left = 0;   ///< image_<left>
  int right = 1;  ///< image_<right>
  StereoCalibration calibration;
  /// Position of the left camera in the frame of camera 0, which `poses.txt` is about. Axes are the same.
  Eigen::Vector3d p_cam0_left = Eigen::Vector3d::Zero();
};

/// Reads `calib.txt` and chooses image_0 and image_1, else image_2 and image_3. Body is level: x = camera z,
/// y = camera -x, z = camera -y, at the left camera. Throws SequenceError with every problem.
KittiCameras ReadKittiCameras(const std::filesystem::path& path);

/// When frame `index` was taken; times.txt counts from zero, which stands for the epoch here.
struct KittiTime {
  std::int64_t index = 0;
  Timestamp t;
};

/// The lines of `times.txt` that hold a time and whose time rises.
Table<KittiTime> ReadKittiTimes(const std::filesystem::path& times);

/// Opens a KITTI odometry folder (also with colour images). Throws SequenceError with every problem.
std::unique_ptr<Sequence> OpenKittiSequence(const std::filesystem::path& path);

}  // namespace terrace
