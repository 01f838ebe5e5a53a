// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "core/lens.h"

namespace terrace {
namespace {

// Half a pixel over the whole image is what rectification itself can promise.
constexpr double kSameIntrinsicsPx = 1e-3;
constexpr double kSameAxis = 1e-6;

std::string Decimal(double value, int digits) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

/// Distance and direction between the cameras; what is wrong with them is said as what it most likely is.
std::string BaselineProblem(const Eigen::Vector3d& p_left_right) {
  constexpr double kShortest = 1e-3;
  constexpr double kLongest = 10.0;
  const double length = p_left_right.norm();
  if (length < kShortest || length > kLongest) {
    std::string text = "baseline of " + Decimal(length, 6) + " m must lie between 0.001 and 10 m";
    if (length > kLongest)
      text += ": in millimetres it is one of " + Decimal(1e-3 * length, 4) + " m, was that the unit?";
    return text;
  }
  const Eigen::Vector3d direction = p_left_right / length;
  if (std::abs(direction.z()) > 0.5) {
    return "the right camera lies " + Decimal(std::abs(p_left_right.z()), 4) + " m " +
           (direction.z() > 0 ? "in front of" : "behind") +
           " the left one along its optical axis: they must stand beside or above each other";
  }
  if (direction.x() < 0.0 && -direction.x() >= std::abs(direction.y())) {
    return "the right camera lies at x = " + Decimal(p_left_right.x(), 6) +
           " m of the left one, must be positive: are left and right swapped?";
  }
  return "";
}

/// How the cameras are turned against each other.
std::string TurnProblem(const Eigen::Matrix3d& R_right_left) {
  constexpr double kLargest = 0.5;
  if (R_right_left.trace() >= 1.0 + 2.0 * std::cos(kLargest)) return "";
  const auto degrees = [](double radians) { return Decimal(radians * 180.0 / M_PI, 3); };
  const double apart = std::acos(std::clamp(R_right_left(2, 2), -1.0, 1.0));
  if (apart <= kLargest) {
    const double roll =
        std::atan2(R_right_left(1, 0) - R_right_left(0, 1), R_right_left(0, 0) + R_right_left(1, 1));
    return "the right camera is turned by " + degrees(roll) +
           " deg about its optical axis against the left one, must be within 29 deg: turn its images and "
           "calibrate again";
  }
  return "the cameras look " + degrees(apart) + " deg apart, must be within 29 deg";
}

}  // namespace

bool RawCamera::distorted() const {
  if (model != DistortionModel::kRadialTangential) return true;
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; });
}

bool StereoCalibration::rectified() const {
  if (left.distorted() || right.distorted()) return false;
  const Eigen::Vector3d& t = T_rawright_rawleft.translation();
  return T_rawright_rawleft.linear().isIdentity(kSameAxis) && std::abs(t.y()) <= kSameAxis * t.norm() &&
         std::abs(t.z()) <= kSameAxis * t.norm() && std::abs(left.fx - right.fx) <= kSameIntrinsicsPx &&
         std::abs(left.fy - right.fy) <= kSameIntrinsicsPx &&
         std::abs(left.cx - right.cx) <= kSameIntrinsicsPx &&
         std::abs(left.cy - right.cy) <= kSameIntrinsicsPx;
}

std::vector<std::string> StereoCalibration::Problems() const {
  std::vector<std::string> problems;
  const auto say = [&](const std::string& text) { problems.push_back(name + ": " + text); };
  if (width < 16 || height < 16 || width > 16384 || height > 16384) {
    say("image size " + std::to_string(width) + "x" + std::to_string(height) +
        " must lie within 16x16 and 16384x16384");
    return problems;
  }
  for (const auto& [side, camera] : {std::pair{"left", &left}, std::pair{"right", &right}}) {
    for (const std::string& problem : LensProblems(*camera, width, height))
      say(std::string(side) + " camera: " + problem);
  }
  const Eigen::Matrix3d R = T_rawright_rawleft.linear();
  const Eigen::Vector3d& t = T_rawright_rawleft.translation();
  if (!R.allFinite() || !t.allFinite() || !(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0) {
    say("the transform between the cameras is not a rotation and a translation");
    return problems;
  }
  for (const std::string& problem : {BaselineProblem(-(R.transpose() * t)), TurnProblem(R)}) {
    if (!problem.empty()) say(problem);
  }
  return problems;
}

}  // namespace terrace
