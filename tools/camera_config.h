// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terrace {

/// A pair of cameras behind one or two video devices: the file that `terrace camera` reads.
struct CameraConfig {
  std::string device = "/dev/video0";
  /// Of the right camera where each has a device of its own. Empty: one device sends both.
  std::string device_right = "";
  /// Of what a device sends as one image: both cameras side by side, or one of them.
  int width = 1280;
  int height = 480;
  double rate_hz = 30.0;
  /// GREY, YUYV or MJPEG (two images side by side), Y8I (both byte by byte).
  std::string format = "YUYV";
  /// The right camera is sent first.
  bool swap = false;
  /// 0: the camera chooses, and t_capture is off by half of what it chooses.
  double exposure_us = 0.0;
  /// As the driver counts it. Negative: is left as it is.
  int gain = -1;
  /// Added to every stamp: what is known of the device and not told by its driver.
  double stamp_offset_ms = 0.0;
  /// Images of two devices that are further apart than this are no pair.
  double max_skew_ms = 3.0;
  /// raw, lossless or mjpeg: how images travel.
  std::string encoding = "raw";

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
  bool has_two_devices() const { return !device_right.empty(); }
};

/// Throws FileError with file, key and rule; an unknown key is an error.
CameraConfig ReadCameraConfig(const std::filesystem::path& path);

}  // namespace terrace
