// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/rectifier.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "core/check.h"
#include "core/field_problems.h"
#include "core/lens.h"

namespace terrace {
namespace {

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

/// One raw camera seen from the rectified axes.
class RawView {
 public:
  RawView(const RawCamera& camera, const Eigen::Matrix3d& R_rect_raw, int width, int height)
      : lens_(camera), R_raw_rect_(R_rect_raw.transpose()), width_(width), height_(height) {}

  /// The raw pixel in direction (x, y, 1) of the rectified axes; none outside the raw image.
  std::optional<Eigen::Vector2d> Pixel(double x, double y) const {
    const std::optional<Eigen::Vector2d> pixel = lens_.Project(R_raw_rect_ * Eigen::Vector3d(x, y, 1.0));
    const bool inside = pixel && pixel->x() >= 0.0 && pixel->x() <= width_ - 1 && pixel->y() >= 0.0 &&
                        pixel->y() <= height_ - 1;
    return inside ? pixel : std::nullopt;
  }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Lens lens_;
  Eigen::Matrix3d R_raw_rect_;
  int width_;
  int height_;
};

/// How far both cameras see from the rectified axis along (dx, dy), as a tangent; at most as far as an image
/// plane holds with sense: beyond 70 deg a step of the angle is eight pixels for one in the middle.
double CommonReach(const RawView& left, const RawView& right, double dx, double dy) {
  constexpr double kStep = 0.002;
  const double kLargest = std::tan(70.0 * M_PI / 180.0);
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

/// "640x480" as numbers; none when it is anything else.
std::optional<std::pair<int, int>> ParseSize(const std::string& text) {
  int width = 0, height = 0;
  char more = 0;
  constexpr int kSmallest = 16;
  constexpr int kLargest = 16384;
  if (std::sscanf(text.c_str(), "%5dx%5d%c", &width, &height, &more) != 2) return std::nullopt;
  if (std::min(width, height) < kSmallest || std::max(width, height) > kLargest) return std::nullopt;
  return std::pair{width, height};
}

/// The widest view that both raw cameras fill. A very wide lens is cut rather than squeezed: flattened, its
/// middle would lose resolution to stretched corners. Cameras that share little of their views keep black
/// borders rather than a needle's view.
StereoCamera ChooseView(const StereoCalibration& calibration, const RectifierConfig& config,
                        std::pair<int, int> size, const RawView& left, const RawView& right) {
  constexpr double kSmallestZoom = 0.8;
  constexpr double kLargestZoom = 1.5;
  const Eigen::Vector2d left_focal_px = Lens(calibration.left).focal_px();
  const Eigen::Vector2d right_focal_px = Lens(calibration.right).focal_px();
  // Images of another size show the same view, larger or smaller.
  const double scale =
      std::hypot(size.first, size.second) / std::hypot(calibration.width, calibration.height);
  const double raw_focal_px = 0.25 * scale * (left_focal_px.sum() + right_focal_px.sum());
  const double x_min = -CommonReach(left, right, -1, 0);
  const double x_max = CommonReach(left, right, 1, 0);
  const double y_min = -CommonReach(left, right, 0, -1);
  const double y_max = CommonReach(left, right, 0, 1);

  StereoCamera camera;
  camera.width = size.first;
  camera.height = size.second;
  camera.baseline_m = calibration.baseline_m();
  const auto zoom_to = [&](double focal_px) {
    camera.fx = camera.fy = focal_px;
    camera.cx = 0.5 * (camera.width - 1) - focal_px * 0.5 * (x_min + x_max);
    camera.cy = 0.5 * (camera.height - 1) - focal_px * 0.5 * (y_min + y_max);
  };
  if (config.rectified_focal_px > 0.0) {
    zoom_to(config.rectified_focal_px);
    return camera;
  }
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
      const int u0 = std::min(static_cast<int>(pixel->x()), view.width() - 2);
      const int v0 = std::min(static_cast<int>(pixel->y()), view.height() - 2);
      taps.push_back({v0 * view.width() + u0,
                      static_cast<std::uint16_t>(std::lround((pixel->x() - u0) * kUnitsPerPixel)),
                      static_cast<std::uint16_t>(std::lround((pixel->y() - v0) * kUnitsPerPixel))});
    }
  }
  return taps;
}

/// Whole numbers only: the same bits on every processor. Black where the raw camera saw nothing.
cv::Mat1b Remap(const GrayImage& raw, const std::vector<Rectifier::Tap>& taps, const StereoCamera& camera) {
  cv::Mat1b out(camera.height, camera.width);
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

std::vector<std::string> RectifierConfig::Problems() const {
  FieldProblems problems;
  problems.Require(rectified_focal_px == 0.0 || (rectified_focal_px >= 10.0 && rectified_focal_px <= 20000.0),
                   "rectified_focal_px", rectified_focal_px, "be 0 or lie between 10 and 20000");
  problems.Require(rectified_size.empty() || ParseSize(rectified_size), "rectified_size", rectified_size,
                   "be empty or read WIDTHxHEIGHT, from 16x16 to 16384x16384");
  return problems.Take();
}

std::pair<int, int> RectifiedSize(const StereoCalibration& calibration, const RectifierConfig& config) {
  if (const auto size = ParseSize(config.rectified_size)) return *size;
  // Where the raw rows point to in the rectified image.
  const Eigen::Vector3d row = RotationsFor(calibration.T_rawright_rawleft).R_rect_rawleft.col(0);
  const bool turned = std::abs(row.y()) > std::abs(row.x());
  return turned ? std::pair{calibration.height, calibration.width}
                : std::pair{calibration.width, calibration.height};
}

Rectifier::Rectifier(const StereoCalibration& calibration, const RectifierConfig& config)
    : raw_width_(calibration.width), raw_height_(calibration.height) {
  const std::vector<std::string> problems = calibration.Problems();
  if (!problems.empty()) {
    std::string text;
    for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
    throw std::invalid_argument(text);
  }
  pass_through_ =
      calibration.rectified() && config.rectified_focal_px == 0.0 && config.rectified_size.empty();
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
  camera_ = ChooseView(calibration, config, RectifiedSize(calibration, config), left, right);
  left_taps_ = TapsFor(camera_, left);
  right_taps_ = TapsFor(camera_, right);
}

StereoFrame Rectifier::Rectify(FrameId frame_id, const StereoPair& pair) const {
  for (const GrayImage* image : {&pair.left, &pair.right}) {
    TERRACE_CHECK(image->width == raw_width_ && image->height == raw_height_ &&
                      image->data.size() == static_cast<std::size_t>(image->width) * image->height,
                  image->width, image->height, image->data.size());
  }
  StereoFrame frame;
  frame.frame_id = frame_id;
  frame.t_capture = pair.t_capture;
  frame.left = pass_through_ ? Copy(pair.left) : Remap(pair.left, left_taps_, camera_);
  frame.right = pass_through_ ? Copy(pair.right) : Remap(pair.right, right_taps_, camera_);
  return frame;
}

}  // namespace terrace
