// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace terrace {

/// A rectified stereo pair: two ideal pinhole cameras with parallel axes and aligned rows. Pixel centres at
/// whole numbers; x right, y down, z forward.
struct StereoCamera {
  int width = 0;
  int height = 0;
  double fx = 0.0;  ///< px
  double fy = 0.0;  ///< px
  double cx = 0.0;  ///< px
  double cy = 0.0;  ///< px
  double baseline_m = 0.0;

  /// Pixel (u, v) in the left image of a point in the left frame, which must have z > 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& p_left) const {
    return {fx * p_left.x() / p_left.z() + cx, fy * p_left.y() / p_left.z() + cy};
  }
  double Disparity(double depth_m) const { return fx * baseline_m / depth_m; }
  double Depth(double disparity_px) const { return fx * baseline_m / disparity_px; }
  /// The point in the left frame seen at pixel (u, v) with this disparity, which must be positive.
  Eigen::Vector3d Triangulate(double u, double v, double disparity_px) const {
    const double z = Depth(disparity_px);
    return {(u - cx) * z / fx, (v - cy) * z / fy, z};
  }
  /// Standard deviation of a depth [m] that comes from a disparity with this standard deviation.
  double DepthSigma(double depth_m, double disparity_sigma_px) const {
    return depth_m * depth_m * disparity_sigma_px / (fx * baseline_m);
  }
};

/// How one raw lens bends rays; the equations are in `lens_models.cpp`.
enum class DistortionModel {
  kRadialTangential,  ///< OpenCV's: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tau_x tau_y]]]], or none
  kEquidistant,       ///< Kannala-Brandt, OpenCV's fisheye: k1 k2 k3 k4, or none
  kOmni,              ///< unified sphere of Mei, as camodocal, Kalibr and OpenCV's omnidir: xi k1 k2 p1 p2
  kDoubleSphere,      ///< xi alpha
  kExtendedUnified,   ///< alpha beta
  kFieldOfView,       ///< w [rad]
  /// OCamCalib: b1 b2 b3 b4, d e c. In units of the focal length: the ray is (m, 1 + b1 |m| + ... + b4 |m|^4)
  /// and the pixel f * [1 d; e c] * m beside the centre.
  kPolynomial,
};
/// "radial-tangential", "equidistant", "omni", "double-sphere", "extended-unified", "field-of-view",
/// "polynomial".
const char* Name(DistortionModel model);
std::optional<DistortionModel> DistortionModelFromName(const std::string& name);

/// One raw camera, as calibration tools give it.
struct RawCamera {
  double fx = 0.0;  ///< px
  double fy = 0.0;  ///< px
  double cx = 0.0;  ///< px
  double cy = 0.0;  ///< px
  DistortionModel model = DistortionModel::kRadialTangential;
  std::vector<double> distortion;  ///< as the model orders them

  bool distorted() const;
};

/// Noise of an IMU, in the units of Kalibr. Zero: not known.
struct ImuNoise {
  double gyro_density = 0.0;   ///< rad / s / sqrt(Hz)
  double gyro_walk = 0.0;      ///< rad / s^2 / sqrt(Hz)
  double accel_density = 0.0;  ///< m / s^2 / sqrt(Hz)
  double accel_walk = 0.0;     ///< m / s^3 / sqrt(Hz)
};

/// Everything known about a stereo rig before rectification.
struct StereoCalibration {
  std::string name;  ///< where it came from, for error messages
  int width = 0;
  int height = 0;
  RawCamera left;
  RawCamera right;
  /// p_rawright = T_rawright_rawleft * p_rawleft; the right camera's centre lies at +x of the left one, or
  /// above or below it.
  Eigen::Isometry3d T_rawright_rawleft = Eigen::Isometry3d::Identity();
  /// Body from the raw left camera; none: no body is known.
  std::optional<Eigen::Isometry3d> T_body_rawleft;
  /// Body from IMU axes; none: there is no calibrated IMU.
  std::optional<Eigen::Isometry3d> T_body_imu;
  ImuNoise imu_noise;

  /// Distance between the optical centres.
  double baseline_m() const { return T_rawright_rawleft.translation().norm(); }
  /// True when the images need no remapping: no distortion, no rotation, equal intrinsics, baseline along x.
  bool rectified() const;
  /// One sentence per rule that this calibration breaks (file or topic `name` first); empty when it makes
  /// sense.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
