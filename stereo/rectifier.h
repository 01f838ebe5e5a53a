// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Turns raw pairs into rectified ones. Tables are built once; an already rectified pair is passed through.
/// Both rectified cameras have the same intrinsics; the view is the widest that both raw images fill, between
/// 0.8 and 1.5 times the raw focal length. Bilinear in whole numbers: the same bits on every processor.
class Rectifier {
 public:
  /// Where one rectified pixel comes from: between the raw pixel at `offset` in the data, its right and its
  /// lower neighbours. Offset -1: from outside the raw image.
  struct Tap {
    std::int32_t offset;
    std::uint16_t du_256;  ///< 1/256 px
    std::uint16_t dv_256;  ///< 1/256 px
  };

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
  std::vector<Tap> left_taps_;
  std::vector<Tap> right_taps_;
};

}  // namespace terrace
