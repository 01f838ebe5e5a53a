// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace terrace::synthetic {
namespace {

constexpr std::array<const char*, kNumPatterns> kPatternNames{
    "plain", "noise", "concrete", "tiles", "wood", "brick", "checker", "posters", "grating"};
constexpr std::array<const char*, 4> kMotionNames{"walk", "stand", "creep", "turn_on_spot"};

}  // namespace

const char* Name(Pattern pattern) { return kPatternNames[static_cast<std::size_t>(pattern)]; }

std::optional<Pattern> PatternFromName(const std::string& name) {
  const auto found = std::find(kPatternNames.begin(), kPatternNames.end(), name);
  if (found == kPatternNames.end()) return std::nullopt;
  return static_cast<Pattern>(found - kPatternNames.begin());
}

const char* Name(MotionKind kind) { return kMotionNames[static_cast<std::size_t>(kind)]; }

std::optional<MotionKind> MotionKindFromName(const std::string& name) {
  const auto found = std::find(kMotionNames.begin(), kMotionNames.end(), name);
  if (found == kMotionNames.end()) return std::nullopt;
  return static_cast<MotionKind>(found - kMotionNames.begin());
}

Eigen::Vector3d MovingObject::OffsetAt(double t_s) const {
  if (keys.empty()) return Eigen::Vector3d::Zero();
  if (t_s <= keys.front().t_s) return keys.front().offset;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (t_s < keys[i].t_s) {
      const double share = (t_s - keys[i - 1].t_s) / (keys[i].t_s - keys[i - 1].t_s);
      return keys[i - 1].offset + share * (keys[i].offset - keys[i - 1].offset);
    }
  }
  return keys.back().offset;
}

Eigen::Isometry3d Mounting::T_body_left() const {
  const double s = std::sin(pitch_down_rad);
  const double c = std::cos(pitch_down_rad);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -s, c,  //
      -1, 0, 0,            //
      0, -c, -s;
  T.rotate(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  T.translation() = left_in_body;
  return T;
}

Eigen::Matrix3d RightCamera::Turn(double fy_px) const {
  return (Eigen::AngleAxisd(-roll_rad, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(std::atan2(row_shift_px, fy_px), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace terrace::synthetic
