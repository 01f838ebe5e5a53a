// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/camera.h"

namespace terrace {

/// What the user says beside calibration files, where these leave it open.
struct RigOptions {
  std::optional<std::pair<int, int>> size;     ///< of the images, px
  std::optional<double> unit_m;                ///< metres per unit of lengths
  std::optional<double> baseline_m;            ///< cameras side by side and parallel
  std::optional<std::pair<int, int>> cameras;  ///< which of several are left and right, counted from 0
};

/// One camera as it was read, for `terrace calibration`.
struct ReadCamera {
  std::string place;
  int width = 0;
  int height = 0;
  RawCamera lens;
};

/// What calibration files hold together.
struct RigReading {
  std::string format;
  std::vector<ReadCamera> cameras;       ///< those with a lens: left, right
  std::optional<StereoCalibration> rig;  ///< none: something is missing
  std::vector<std::string> missing;      ///< for a rig, a sentence each
  std::vector<std::string> problems;     ///< what cannot be, a sentence each
  std::vector<std::string> notes;        ///< what was taken for granted, a sentence each
  std::optional<double> imu_minus_camera_s;
};

/// Reads the calibration of one rig from files of any format that datasets/README.md lists, recognised by
/// what they hold: one file, or one a camera, or intrinsics and extrinsics apart. A folder that holds `mav0/`
/// stands for its sensor files. Throws SequenceError when a file cannot be read, with every problem.
RigReading ReadCalibrationFiles(const std::vector<std::filesystem::path>& files,
                                const RigOptions& options = {});

/// The rig alone; notes are handed over. Throws SequenceError also when anything is missing or makes no
/// sense.
StereoCalibration ReadRig(const std::vector<std::filesystem::path>& files, std::vector<std::string>* notes,
                          const RigOptions& options = {});

/// "left.yaml, right.yaml" as paths.
std::vector<std::filesystem::path> SplitFileList(const std::string& text);

}  // namespace terrace
