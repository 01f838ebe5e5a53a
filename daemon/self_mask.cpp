// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/self_mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include <opencv2/core.hpp>

#include "core/field_problems.h"
#include "core/plane_rings.h"
#include "daemon/config.h"
#include "datasets/image_file.h"
#include "stereo/image_scale.h"
#include "stereo/rectifier.h"

namespace terrace {
namespace {

constexpr std::size_t kBoxNumbers = 6, kCapsuleNumbers = 7;
// Beyond this the odometry believes a calibration's body only when the robot itself confirms it, which nobody
// knows yet.
const double kDoubtfulTiltCosine = std::cos(M_PI / 3.0);
// Of numbers that may be part of a robot.
constexpr double kLargestRobotM = 10.0;

/// What leaves the camera through one pixel, in the body.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  // unit
};

struct Box {
  Eigen::AlignedBox3d box;

  bool Contains(const Eigen::Vector3d& p) const { return box.contains(p); }
  /// By the intervals in which the ray is between each pair of opposite faces.
  bool Hides(const Ray& ray) const {
    double begin = 0.0, end = 2.0 * kLargestRobotM;
    for (int axis = 0; axis < 3; ++axis) {
      const double inverse = 1.0 / ray.direction[axis];  // infinite along a face, which comes out right
      const double a = (box.min()[axis] - ray.origin[axis]) * inverse;
      const double b = (box.max()[axis] - ray.origin[axis]) * inverse;
      begin = std::max(begin, std::min(a, b));
      end = std::min(end, std::max(a, b));
    }
    return begin <= end;
  }
};

struct Capsule {
  Eigen::Vector3d from, to;
  double radius_m;

  double DistanceTo(const Eigen::Vector3d& p) const { return (NearestOnSegment(from, to, p) - p).norm(); }
  bool Contains(const Eigen::Vector3d& p) const { return DistanceTo(p) <= radius_m; }
  /// The ray's point nearest to the axis lies between those nearest to its ends; the distance to a segment is
  /// convex along a line, so halving by thirds finds it.
  bool Hides(const Ray& ray) const {
    double a = std::max(0.0, (from - ray.origin).dot(ray.direction));
    double b = std::max(0.0, (to - ray.origin).dot(ray.direction));
    if (a > b) std::swap(a, b);
    constexpr int kSteps = 40;  // (2/3)^40 of a robot is less than a micrometre
    for (int i = 0; i < kSteps; ++i) {
      const double third = (b - a) / 3.0;
      const double left = DistanceTo(ray.origin + (a + third) * ray.direction);
      const double right = DistanceTo(ray.origin + (b - third) * ray.direction);
      (left < right ? b : a) += left < right ? -third : third;
    }
    return DistanceTo(ray.origin + a * ray.direction) <= radius_m;
  }
};

std::vector<Box> BoxesOf(const std::vector<double>& numbers) {
  std::vector<Box> boxes;
  for (std::size_t i = 0; i + kBoxNumbers <= numbers.size(); i += kBoxNumbers) {
    Eigen::AlignedBox3d box(Eigen::Vector3d(numbers[i], numbers[i + 1], numbers[i + 2]));
    box.extend(Eigen::Vector3d(numbers[i + 3], numbers[i + 4], numbers[i + 5]));
    boxes.push_back({box});
  }
  return boxes;
}

std::vector<Capsule> CapsulesOf(const std::vector<double>& n) {
  std::vector<Capsule> capsules;
  for (std::size_t i = 0; i + kCapsuleNumbers <= n.size(); i += kCapsuleNumbers)
    capsules.push_back({{n[i], n[i + 1], n[i + 2]}, {n[i + 3], n[i + 4], n[i + 5]}, n[i + 6]});
  return capsules;
}

template <typename Part>
void HidePart(const Part& part, const StereoCamera& camera, const Eigen::Isometry3d& T_body_left,
              cv::Mat1b* mask) {
  if (part.Contains(T_body_left.translation()))
    throw ConfigError("robot.self_boxes_m, self_capsules_m: the left camera is inside one of them");
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d p_left((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      if (part.Hides({T_body_left.translation(), (T_body_left.linear() * p_left).normalized()}))
        (*mask)(v, u) = 0;
    }
  }
}

/// As the file has it.
GrayImage ReadMask(const std::string& png, std::pair<int, int> size, const std::string& pixels) {
  GrayImage image;
  try {
    image = ReadGrayImage(png);
  } catch (const std::exception& error) {
    throw ConfigError("robot.self_mask_png = " + png + ": " + error.what());
  }
  if (std::pair(image.width, image.height) != size) {
    throw ConfigError("robot.self_mask_png = " + png + " is " + std::to_string(image.width) + "x" +
                      std::to_string(image.height) + ", the " + pixels + " images are " +
                      std::to_string(size.first) + "x" + std::to_string(size.second) +
                      " (robot.self_mask_pixels: rectified or raw)");
  }
  return image;
}

cv::Mat1b ToMask(const GrayImage& image) {
  cv::Mat1b mask(image.height, image.width);
  std::copy(image.data.begin(), image.data.end(), mask.begin());
  return mask;
}

/// A pixel is hidden as soon as any raw pixel that it is mixed from is, or where the raw image ends.
cv::Mat1b RectifiedMask(const Rectifier& rectifier, GrayImage raw) {
  constexpr std::uint8_t kSeen = 255;
  for (std::uint8_t& value : raw.data) value = value == 0 ? 0 : kSeen;
  StereoPair pair;
  pair.right = raw;
  pair.left = std::move(raw);
  cv::Mat1b mask = rectifier.Rectify(0, pair).left.clone();
  for (std::uint8_t& value : mask) value = value == kSeen ? kSeen : 0;
  return mask;
}

}  // namespace

std::vector<std::string> SelfMaskConfig::Problems() const {
  FieldProblems problems;
  problems.Require(self_mask_pixels == "rectified" || self_mask_pixels == "raw", "self_mask_pixels",
                   self_mask_pixels, "be rectified or raw");
  problems.Require(self_boxes_m.size() % kBoxNumbers == 0, "self_boxes_m", self_boxes_m,
                   "hold six numbers a box: two opposite corners");
  problems.Require(self_capsules_m.size() % kCapsuleNumbers == 0, "self_capsules_m", self_capsules_m,
                   "hold seven numbers a capsule: two ends, radius");
  for (const auto& [name, numbers] :
       {std::pair{"self_boxes_m", &self_boxes_m}, std::pair{"self_capsules_m", &self_capsules_m}}) {
    problems.Require(
        std::all_of(numbers->begin(), numbers->end(), [](double x) { return std::abs(x) <= kLargestRobotM; }),
        name, *numbers, "lie within 10 m of the body");
  }
  const std::vector<Capsule> capsules = CapsulesOf(self_capsules_m);
  problems.Require(
      std::all_of(capsules.begin(), capsules.end(), [](const Capsule& c) { return c.radius_m > 0.0; }),
      "self_capsules_m", self_capsules_m, "have radii above 0");
  return problems.Take();
}

void HideParts(const SelfMaskConfig& parts, const StereoCamera& camera, const Eigen::Isometry3d& T_body_left,
               cv::Mat1b* mask) {
  for (const Box& box : BoxesOf(parts.self_boxes_m)) HidePart(box, camera, T_body_left, mask);
  for (const Capsule& capsule : CapsulesOf(parts.self_capsules_m))
    HidePart(capsule, camera, T_body_left, mask);
}

namespace {

/// @param calibration  of the images as they are worked on
cv::Mat1b MakeSelfMask(const PipelineConfig& config, const StereoCalibration& calibration) {
  const std::string& png = config.terrain.robot.self_mask_png;
  const SelfMaskConfig& parts = config.self_mask;
  const bool is_raw = parts.self_mask_pixels == "raw";
  cv::Mat1b mask;
  if (!png.empty() && !is_raw)
    mask = ToMask(ReadMask(png, RectifiedSize(calibration, config.rectifier), parts.self_mask_pixels));
  if (!parts.has_parts() && (png.empty() || !is_raw)) return mask;
  const Rectifier rectifier(calibration, config.rectifier);
  if (!png.empty() && is_raw) {
    const std::pair<int, int> raw_size(calibration.width, calibration.height);
    mask = RectifiedMask(rectifier, ReadMask(png, raw_size, parts.self_mask_pixels));
  }
  if (!parts.has_parts()) return mask;
  const Mounting mounting = MountingOf(config.mounting, calibration, rectifier.R_rect_raw());
  const bool known = mounting.T_body_left && mounting.source != MountingSource::kSensor;
  const bool believed =
      known && (mounting.source == MountingSource::kBody ||
                mounting.T_body_left->linear().row(2).dot(mounting.image_up_left) >= kDoubtfulTiltCosine);
  if (!believed) {
    throw ConfigError(
        "robot.self_boxes_m, self_capsules_m: how the camera sits on the body is not known; say it in "
        "camera.mounting (source: body where the calibration's is the robot's)");
  }
  if (mask.empty()) mask = cv::Mat1b(rectifier.camera().height, rectifier.camera().width, std::uint8_t{255});
  HideParts(parts, rectifier.camera(), *mounting.T_body_left, &mask);
  return mask;
}

}  // namespace

cv::Mat1b LoadSelfMask(const PipelineConfig& config, const StereoCalibration& calibration) {
  cv::Mat1b mask = MakeSelfMask(config, Scaled(calibration, config.image_scale));
  constexpr double kLeastSeen = 0.02;
  const auto num_pixels = static_cast<double>(mask.total());
  if (!mask.empty() && cv::countNonZero(mask) < kLeastSeen * num_pixels) {
    const std::string& png = config.terrain.robot.self_mask_png;
    throw ConfigError((png.empty() ? "robot.self_boxes_m, self_capsules_m" : "robot.self_mask_png = " + png) +
                      " leaves less than 2 % of the image to see: in a mask, black is the robot itself and "
                      "white is seen");
  }
  return mask;
}

}  // namespace terrace
