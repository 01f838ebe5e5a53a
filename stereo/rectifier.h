// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// Which view of a raw pair is rectified. YAML section: `stereo`.
struct RectifierConfig {
  /// Focal length of the rectified pair. 0: the widest view that both raw images fill, between 0.8 and 1.5
  /// times the focal length that the lens has on its axis. A pair that is rectified already is then left as
  /// it is.
  double rectified_focal_px = 0.0;
  /// Size of the rectified images, as 640x480. Empty: that of the raw images, turned with them where one
  /// camera stands above the other.
  std::string rectified_size = "";

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// Width and height of the rectified images. Throws nothing: the settings must have no problems.
std::pair<int, int> RectifiedSize(const StereoCalibration& calibration, const RectifierConfig& config);

/// Turns raw pairs into rectified ones. Tables are built once; an already rectified pair is passed through.
/// Both rectified cameras have the same intrinsics. Of lenses wider than a pinhole can hold the middle is
/// kept. A pair of which one camera stands above the other is turned by 90 deg, so that its baseline lies
/// along the rows. Bilinear in whole numbers: the same bits on every processor.
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
  explicit Rectifier(const StereoCalibration& calibration, const RectifierConfig& config = {});

  /// The rectified pair.
  const StereoCamera& camera() const { return camera_; }
  /// p_left = R_rect_raw * p_rawleft.
  const Eigen::Matrix3d& R_rect_raw() const { return R_rect_raw_; }

  /// Images must have the size of the calibration (a broken promise otherwise).
  StereoFrame Rectify(FrameId frame_id, const StereoPair& pair) const;

 private:
  StereoCamera camera_;
  int raw_width_ = 0;
  int raw_height_ = 0;
  Eigen::Matrix3d R_rect_raw_ = Eigen::Matrix3d::Identity();
  bool pass_through_ = false;
  std::vector<Tap> left_taps_;
  std::vector<Tap> right_taps_;
};

}  // namespace terrace
