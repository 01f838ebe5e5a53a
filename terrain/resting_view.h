// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "stereo/disparity_image.h"

namespace terrace {

/// Tells when a camera that rests has shown the same for so long that one more frame of it says nothing new:
/// the errors of matching are those of the frame before, and would only be taken for evidence. A map that is
/// left alone then has no ids that come and go, and costs nothing.
class RestingView {
 public:
  /// @return true when this frame shows what the ones before have shown, from where they have
  bool ShowsNothingNew(const DisparityImage& disparity, const Eigen::Isometry3d& T_world_left);

 private:
  /// The frame with which the rest began.
  struct Reference {
    Eigen::Isometry3d T_world_left;
    cv::Mat1f samples_px;       // of its disparity, some pixels apart
    cv::Mat1f last_samples_px;  // of the last frame that was added
    int num_frames = 1;         // that have shown the same since, this one among them
    int num_odd = 0;            // frames in a row in which a few tiles differ
  };

  /// Than the reference, from the same place.
  bool ShowsSomethingElse(const cv::Mat1f& samples_px);

  std::optional<Reference> reference_;
};

}  // namespace terrace
