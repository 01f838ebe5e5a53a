// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/calibration_formats.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <initializer_list>

namespace terrace {
namespace {

std::string LowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

std::optional<DistortionModel> ModelOfAnyName(std::string name) {
  name = LowerCase(std::move(name));
  const auto is_one_of = [&](std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
  };
  if (is_one_of({"radtan", "radial-tangential", "plumb_bob", "rational_polynomial", "brown conrady",
                 "brown_conrady", "none", ""})) {
    return DistortionModel::kRadialTangential;
  }
  if (is_one_of({"equidistant", "fisheye", "kannala_brandt", "kannala_brandt4", "kannala brandt4", "kb4"}))
    return DistortionModel::kEquidistant;
  if (is_one_of({"fov", "f-theta", "ftheta"})) return DistortionModel::kFieldOfView;
  return DistortionModelFromName(name);
}

RawCamera LensFromMatrix(const Eigen::Matrix3d& K, DistortionModel model, std::vector<double> distortion) {
  return {K(0, 0), K(1, 1), K(0, 2), K(1, 2), model, std::move(distortion)};
}

CameraSide SideOfName(std::string name) {
  name = LowerCase(std::move(name));
  const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
  const bool left = has("left") || has("cam0") || has("infra1") || has("infrared1") || has("infrared 1");
  const bool right = has("right") || has("cam1") || has("infra2") || has("infrared2") || has("infrared 2");
  if (left == right) return CameraSide::kUnknown;
  return left ? CameraSide::kLeft : CameraSide::kRight;
}

std::vector<double> NumbersIn(const std::string& text) {
  std::vector<double> numbers;
  const char* at = text.c_str();
  const char* const end = at + text.size();
  while (at < end) {
    char* after = nullptr;
    const double value = std::strtod(at, &after);
    if (after != at && std::isfinite(value)) numbers.push_back(value);
    at = after == at ? at + 1 : after;
  }
  return numbers;
}

}  // namespace terrace
