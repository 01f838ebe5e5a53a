// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/time.h"
#include "stereo/disparity_image.h"

namespace terrace {

/// One triangulated pixel.
struct CloudPoint {
  Eigen::Vector3f p_left;  ///< m
  std::uint16_t u, v;      ///< the pixel of the left image that shows it
  float sigma_depth_m;     ///< standard deviation of z; the error of x and y follows along the ray
};

/// The points of one disparity image, in rows from top to bottom, in the left frame.
struct Cloud {
  FrameId frame_id = 0;
  Timestamp t_capture;
  std::vector<CloudPoint> points;
  /// One in sixteen of those that are too uncertain to be mapped: they tell that nothing stands before them.
  std::vector<CloudPoint> uncertain;
};

/// Settings of the triangulation. YAML section: `mapping`.
struct CloudConfig {
  /// Points whose depth is less certain than this are not mapped; they only tell that the way to them is
  /// free.
  double max_depth_sigma_m = 0.065;
  /// Where pixels lie denser across the view than this, only every second, fourth, ... row and column is
  /// taken. Elsewhere half of the pixels are, like the white fields of a chessboard: neighbours err alike,
  /// and half of them say as much as all.
  double min_spacing_m = 0.01;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// Points of a disparity image, each with its uncertainty.
/// @param mask  CV_8UC1 of the image's size, 0 where the robot sees itself; empty: no mask.
Cloud Triangulate(const DisparityImage& disparity, const StereoCamera& camera, const CloudConfig& config,
                  const cv::Mat1b& mask = {});

}  // namespace terrace
