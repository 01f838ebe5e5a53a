// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/camera.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// What is known about a pixel of the left image.
enum Visibility : std::uint8_t {
  kNoTruth = 0,
  kHidden = 128,   ///< its disparity is known, but the right camera does not see it
  kVisible = 255,  ///< seen by both
};

/// One flat piece of the scene in a rendered picture.
struct TruePatch {
  cv::Mat1b mask;  ///< well inside the patch
};

/// A rectified pair with true disparities.
struct TruthPair {
  std::string name;
  StereoFrame frame;
  int max_disparity_px = 64;
  cv::Mat1f disparity_px;          ///< NaN where nothing is known
  cv::Mat1b visibility;            ///< Visibility
  StereoCamera camera;             ///< of rendered pairs
  std::vector<TruePatch> patches;  ///< steps within 2.5 m, of rendered pairs
};

/// `data` is the folder that TERRACE_DATA names.
std::vector<TruthPair> ReadMiddleburyV3(const std::filesystem::path& data);
std::vector<TruthPair> ReadMiddlebury2001To2003(const std::filesystem::path& data);
/// Every frame of the rendered sequence that has a depth image, every `stride`-th of them.
std::vector<TruthPair> ReadRendered(const std::filesystem::path& sequence, int stride);

}  // namespace terrace
