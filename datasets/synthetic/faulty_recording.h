// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/sensor_frame.h"

namespace terrace::synthetic {

/// One image of a recording, as its file.
struct RecordedImage {
  Timestamp t;                   ///< as it is told
  Timestamp t_true;              ///< when it was due
  std::filesystem::path source;  ///< whose bytes it has, unless one of the following is set
  std::optional<GrayImage> pixels;
  std::optional<std::vector<std::uint8_t>> bytes;  ///< of a file that need not be an image

  /// To be changed: decoded when that is needed for the first time. Throws FileError.
  GrayImage& Edit();
};

/// A row of `attitude0` or `legs0`: position [m], quaternion w x y z, 6 standard deviations.
struct RecordedPrior {
  Timestamp t;
  std::array<double, 13> values{};

  Eigen::Isometry3d T_odom_body() const;
  void Set(const Eigen::Isometry3d& T_odom_body);
};

/// What the sensors of a EuRoC folder have said, to be damaged.
struct FaultyRecording {
  std::filesystem::path source;
  std::vector<RecordedImage> left, right;
  std::vector<ImuSample> imu;
  std::vector<RecordedPrior> attitude, legs;

  /// Keeps what is up to a time.
  void EndAt(Timestamp t_last);
};

/// Reads a EuRoC folder whose two cameras have as many images. Images are not decoded. Throws FileError.
FaultyRecording ReadRecording(const std::filesystem::path& folder);

/// Writes it into another folder that exists, with everything else that the source holds; the true poses get
/// the times of the left images as they are told. Throws FileError.
void WriteRecording(const FaultyRecording& recording, const std::filesystem::path& folder);

}  // namespace terrace::synthetic
