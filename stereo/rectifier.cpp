// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/rectifier.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <Eigen/Geometry>

#include "core/check.h"

namespace terrace {
namespace {

/// Pixel of a ray that leaves the raw lens in direction (x, y, 1).
Eigen::Vector2d ProjectRaw(const RawCamera& camera, double x, double y) {
  const auto k = [&](std::size_t i) { return i < camera.distortion.size() ? camera.distortion[i] : 0.0; };
  if (camera.model == DistortionModel::kEquidistant) {
    const double r = std::hypot(x, y);
    const double theta = std::atan(r);
    const double theta2 = theta * theta;
    const double theta_d =
        theta * (1.0 + theta2 * (k(0) + theta2 * (k(1) + theta2 * (k(2) + theta2 * k(3)))));
    const double scale = r > 1e-9 ? theta_d / r : 1.0;
    return {camera.fx * scale * x + camera.cx, camera.fy * scale * y + camera.cy};
  }
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k(0) + r2 * (k(1) + r2 * k(4)));
  return {camera.fx * (x * radial + 2.0 * k(2) * x * y + k(3) * (r2 + 2.0 * x * x)) + camera.cx,
          camera.fy * (y * radial + k(2) * (r2 + 2.0 * y * y) + 2.0 * k(3) * x * y) + camera.cy};
}

/// Rotations that turn both cameras half way towards each other and their x axes onto the baseline.
struct RectifyingRotations {
  Eigen::Matrix3d R_rect_rawleft;
  Eigen::Matrix3d R_rect_rawright;
};

RectifyingRotations RotationsFor(const Eigen::Isometry3d& T_rawright_rawleft) {
  const Eigen::AngleAxisd between(Eigen::Matrix3d(T_rawright_rawleft.linear()));
  const Eigen::Matrix3d R_half_left =
      Eigen::AngleAxisd(0.5 * between.angle(), between.axis()).toRotationMatrix();
  const Eigen::Matrix3d R_half_right = R_half_left.transpose();
  // The right camera's centre seen from the left one, in the half-way axes.
  const Eigen::Vector3d baseline = -(R_half_right * T_rawright_rawleft.translation());
  const Eigen::Matrix3d R_align =
      Eigen::Quaterniond::FromTwoVectors(baseline, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return {R_align * R_half_left, R_align * R_half_right};
}

/// Beyond this tangent of the angle to the axis the polynomial of the lens turns back: what it says there is
/// a ghost.
double LargestTrueTangent(const RawCamera& camera) {
  constexpr double kStep = 0.01;
  constexpr double kLargest = 20.0;  // 87 deg
  const RawCamera axis{1.0, 1.0, 0.0, 0.0, camera.model, camera.distortion};
  double previous = 0.0;
  for (double r = kStep; r < kLargest; r += kStep) {
    const double here = ProjectRaw(axis, r, 0.0).x();
    if (here <= previous) return r - kStep;
    previous = here;
  }
  return kLargest;
}

/// One raw camera seen from the rectified axes.
class RawView {
 public:
  RawView(const RawCamera& camera, const Eigen::Matrix3d& R_rect_raw, int width, int height)
      : camera_(camera),
        R_raw_rect_(R_rect_raw.transpose()),
        largest_tangent_(LargestTrueTangent(camera)),
        width_(width),
        height_(height) {}

  /// The raw pixel in direction (x, y, 1) of the rectified axes; none outside the raw image.
  std::optional<Eigen::Vector2d> Pixel(double x, double y) const {
    const Eigen::Vector3d ray = R_raw_rect_ * Eigen::Vector3d(x, y, 1.0);
    if (ray.z() <= 0.0) return std::nullopt;
    const double x_raw = ray.x() / ray.z();
    const double y_raw = ray.y() / ray.z();
    if (std::hypot(x_raw, y_raw) > largest_tangent_) return std::nullopt;
    const Eigen::Vector2d pixel = ProjectRaw(camera_, x_raw, y_raw);
    const bool inside =
        pixel.x() >= 0.0 && pixel.x() <= width_ - 1 && pixel.y() >= 0.0 && pixel.y() <= height_ - 1;
    return inside ? std::optional(pixel) : std::nullopt;
  }

 private:
  RawCamera camera_;
  Eigen::Matrix3d R_raw_rect_;
  double largest_tangent_;
  int width_;
  int height_;
};

/// How far both cameras see from the rectified axis along (dx, dy), as a tangent.
double CommonReach(const RawView& left, const RawView& right, double dx, double dy) {
  constexpr double kStep = 0.002;
  constexpr double kLargest = 20.0;
  double reach = 0.0;
  for (double r = 0.0; r < kLargest && left.Pixel(r * dx, r * dy) && right.Pixel(r * dx, r * dy); r += kStep)
    reach = r;
  return reach;
}

/// True when every border pixel of the rectified images comes from inside both raw images.
bool Filled(const StereoCamera& camera, const RawView& left, const RawView& right) {
  const auto seen = [&](int u, int v) {
    const double x = (u - camera.cx) / camera.fx;
    const double y = (v - camera.cy) / camera.fy;
    return left.Pixel(x, y) && right.Pixel(x, y);
  };
  for (int u = 0; u < camera.width; ++u) {
    if (!seen(u, 0) || !seen(u, camera.height - 1)) return false;
  }
  for (int v = 0; v < camera.height; ++v) {
    if (!seen(0, v) || !seen(camera.width - 1, v)) return false;
  }
  return true;
}

/// The widest view that both raw cameras fill. A very wide lens is cut rather than squeezed: flattened, its
/// middle would lose resolution to stretched corners. Cameras that share little of their views keep black
/// borders rather than a needle's view.
StereoCamera ChooseView(const StereoCalibration& calibration, const RawView& left, const RawView& right) {
  constexpr double kSmallestZoom = 0.8;
  constexpr double kLargestZoom = 1.5;
  const double raw_focal_px =
      0.25 * (calibration.left.fx + calibration.left.fy + calibration.right.fx + calibration.right.fy);
  const double x_min = -CommonReach(left, right, -1, 0);
  const double x_max = CommonReach(left, right, 1, 0);
  const double y_min = -CommonReach(left, right, 0, -1);
  const double y_max = CommonReach(left, right, 0, 1);

  StereoCamera camera;
  camera.width = calibration.width;
  camera.height = calibration.height;
  camera.baseline_m = calibration.baseline_m();
  const auto zoom_to = [&](double focal_px) {
    camera.fx = camera.fy = focal_px;
    camera.cx = 0.5 * (camera.width - 1) - focal_px * 0.5 * (x_min + x_max);
    camera.cy = 0.5 * (camera.height - 1) - focal_px * 0.5 * (y_min + y_max);
  };
  double low = kSmallestZoom * raw_focal_px;
  double high = kLargestZoom * raw_focal_px;
  zoom_to(low);
  if (Filled(camera, left, right)) return camera;
  constexpr int kBisections = 40;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    zoom_to(middle);
    (Filled(camera, left, right) ? high : low) = middle;
  }
  zoom_to(high);
  return camera;
}

/// Bilinear taps: the raw pixel at the upper left and how far to go from it, in 1/256 pixel.
std::vector<Rectifier::Tap> TapsFor(const StereoCamera& camera, const RawView& view) {
  constexpr double kUnitsPerPixel = 256.0;
  std::vector<Rectifier::Tap> taps;
  taps.reserve(static_cast<std::size_t>(camera.width) * camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto pixel = view.Pixel((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      if (!pixel) {
        taps.push_back({-1, 0, 0});
        continue;
      }
      const int u0 = std::min(static_cast<int>(pixel->x()), camera.width - 2);
      const int v0 = std::min(static_cast<int>(pixel->y()), camera.height - 2);
      taps.push_back({v0 * camera.width + u0,
                      static_cast<std::uint16_t>(std::lround((pixel->x() - u0) * kUnitsPerPixel)),
                      static_cast<std::uint16_t>(std::lround((pixel->y() - v0) * kUnitsPerPixel))});
    }
  }
  return taps;
}

/// Whole numbers only: the same bits on every processor. Black where the raw camera saw nothing.
cv::Mat1b Remap(const GrayImage& raw, const std::vector<Rectifier::Tap>& taps) {
  cv::Mat1b out(raw.height, raw.width);
  const std::uint8_t* pixels = raw.data.data();
  const int stride = raw.width;
  std::uint8_t* to = out.data;
  for (const Rectifier::Tap& tap : taps) {
    if (tap.offset < 0) {
      *to++ = 0;
      continue;
    }
    const std::uint8_t* from = pixels + tap.offset;
    const std::uint32_t a = tap.du_256, b = tap.dv_256;
    const std::uint32_t above = from[0] * (256 - a) + from[1] * a;
    const std::uint32_t below = from[stride] * (256 - a) + from[stride + 1] * a;
    *to++ = static_cast<std::uint8_t>((above * (256 - b) + below * b + 32768) >> 16);
  }
  return out;
}

cv::Mat1b Copy(const GrayImage& image) {
  return cv::Mat1b(image.height, image.width, const_cast<std::uint8_t*>(image.data.data())).clone();
}

}  // namespace

Rectifier::Rectifier(const StereoCalibration& calibration) {
  const std::vector<std::string> problems = calibration.Problems();
  if (!problems.empty()) {
    std::string text;
    for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
    throw std::invalid_argument(text);
  }
  pass_through_ = calibration.rectified();
  if (pass_through_) {
    const RawCamera& left = calibration.left;
    camera_ = {calibration.width, calibration.height,      left.fx, left.fy, left.cx,
               left.cy,           calibration.baseline_m()};
    return;
  }
  const RectifyingRotations rotations = RotationsFor(calibration.T_rawright_rawleft);
  R_rect_raw_ = rotations.R_rect_rawleft;
  const RawView left(calibration.left, rotations.R_rect_rawleft, calibration.width, calibration.height);
  const RawView right(calibration.right, rotations.R_rect_rawright, calibration.width, calibration.height);
  camera_ = ChooseView(calibration, left, right);
  left_taps_ = TapsFor(camera_, left);
  right_taps_ = TapsFor(camera_, right);
}

StereoFrame Rectifier::Rectify(FrameId frame_id, const StereoPair& pair) const {
  for (const GrayImage* image : {&pair.left, &pair.right}) {
    TERRACE_CHECK(image->width == camera_.width && image->height == camera_.height &&
                      image->data.size() == static_cast<std::size_t>(image->width) * image->height,
                  image->width, image->height, image->data.size());
  }
  StereoFrame frame;
  frame.frame_id = frame_id;
  frame.t_capture = pair.t_capture;
  frame.left = pass_through_ ? Copy(pair.left) : Remap(pair.left, left_taps_);
  frame.right = pass_through_ ? Copy(pair.right) : Remap(pair.right, right_taps_);
  return frame;
}

}  // namespace terrace
