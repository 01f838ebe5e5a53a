// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Turns raw pairs into rectified ones. Tables are built once; an already rectified pair is passed through.
class Rectifier {
 public:
  /// Throws std::invalid_argument with every problem when the calibration makes no sense.
  explicit Rectifier(const StereoCalibration& calibration);

  /// The rectified pair.
  const StereoCamera& camera() const { return camera_; }
  /// p_left = R_rect_raw * p_rawleft.
  const Eigen::Matrix3d& R_rect_raw() const { return R_rect_raw_; }

  /// Images must have the size of the calibration (a broken promise otherwise).
  StereoFrame Rectify(FrameId frame_id, const StereoPair& pair) const;

 private:
  StereoCamera camera_;
  Eigen::Matrix3d R_rect_raw_ = Eigen::Matrix3d::Identity();
  bool pass_through_ = false;
  cv::Mat left_map_xy_, left_map_fraction_;  // fixed-point tables of cv::remap
  cv::Mat right_map_xy_, right_map_fraction_;
};

}  // namespace terrace
