// SPDX-License-Identifier: BSD-3-Clause
#include "core/camera.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace terrace {
namespace {

// Half a pixel over the whole image is what rectification itself can promise.
constexpr double kSameIntrinsicsPx = 1e-3;
constexpr double kSameAxis = 1e-6;

void CheckRawCamera(const RawCamera& camera, const std::string& who, int width, int height,
                    std::vector<std::string>* problems) {
  const auto say = [&](const std::string& text) { problems->push_back(who + ": " + text); };
  const auto number = [](double v) {
    std::ostringstream text;
    text << v;
    return text.str();
  };
  const double largest = std::max(width, height);
  for (const auto& [name, focal] : {std::pair{"fx", camera.fx}, std::pair{"fy", camera.fy}}) {
    // 0.1 image widths is a view of 157 deg, 20 is one of 3 deg: nobody walks with either.
    if (!(focal >= 0.1 * largest && focal <= 20.0 * largest)) {
      say(std::string(name) + " = " + number(focal) + " px is outside the image's scale (" +
          number(0.1 * largest) + " to " + number(20.0 * largest) + ")");
    }
  }
  if (camera.fx > 0 && camera.fy > 0 && !(camera.fx / camera.fy > 0.5 && camera.fx / camera.fy < 2.0)) {
    say("fx / fy = " + number(camera.fx / camera.fy) + ", must lie between 0.5 and 2");
  }
  if (!(camera.cx > -0.5 * width && camera.cx < 1.5 * width)) {
    say("cx = " + number(camera.cx) + " lies far outside the image of width " + number(width));
  }
  if (!(camera.cy > -0.5 * height && camera.cy < 1.5 * height)) {
    say("cy = " + number(camera.cy) + " lies far outside the image of height " + number(height));
  }
  for (const double k : camera.distortion) {
    if (!std::isfinite(k)) say("a distortion coefficient is not a finite number");
  }
  const std::size_t n = camera.distortion.size();
  if (camera.model == DistortionModel::kEquidistant ? (n != 0 && n != 4) : (n != 0 && n != 4 && n != 5)) {
    say(number(static_cast<double>(n)) + " distortion coefficients, the model takes " +
        (camera.model == DistortionModel::kEquidistant ? "4" : "4 or 5"));
  }
}

}  // namespace

bool RawCamera::distorted() const {
  if (model == DistortionModel::kEquidistant) return true;
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
  CheckRawCamera(left, name + ": left camera", width, height, &problems);
  CheckRawCamera(right, name + ": right camera", width, height, &problems);
  const Eigen::Matrix3d R = T_rawright_rawleft.linear();
  const Eigen::Vector3d& t = T_rawright_rawleft.translation();
  if (!R.allFinite() || !t.allFinite() || !(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0) {
    say("the transform between the cameras is not a rotation and a translation");
    return problems;
  }
  std::ostringstream text;
  if (t.norm() < 1e-3 || t.norm() > 10.0) {
    text << "baseline of " << t.norm() << " m must lie between 0.001 and 10 m";
    say(text.str());
  } else if (-t.x() < 0.5 * t.norm()) {
    text << "the right camera lies at x = " << -(R.transpose() * t).x()
         << " m of the left one, must be positive: are left and right swapped?";
    say(text.str());
  }
  if (R.trace() < 1.0 + 2.0 * std::cos(0.5)) say("the cameras look more than 29 deg apart");
  return problems;
}

}  // namespace terrace
