// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include <opencv2/core/mat.hpp>

namespace terrace {

/// The size of a patch. Its middle is the pixel after its first half.
constexpr int kPatchWidth = 16, kPatchHeight = 8;

/// Where a patch of the left image may be in the right one.
struct PatchRange {
  int num_disparities = 64;           ///< from 0 on
  int least_rows = 0, most_rows = 0;  ///< further down, or up
};

/// Where it is: at (u - disparity, v + rows).
struct PatchMatch {
  int disparity = 0, rows = 0;
};

/// Where the right image agrees best with the patch around pixel (u, v) of the left one, by the sum of
/// absolute differences; nothing where another place agrees almost as well, where little agrees at all, where
/// the patch has no texture in one of the directions, or where it leads out of an image. Both images are
/// equally bright.
std::optional<PatchMatch> FindPatch(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v,
                                    const PatchRange& range);

}  // namespace terrace
