// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

constexpr double kMillimetre = 1e-3;

/// The sizes that a ZED has, by the ending that its sections carry.
struct ZedSize {
  const char* name;
  int width;
  int height;
};
constexpr std::array kZedSizes = {ZedSize{"HD", 1280, 720},       ZedSize{"FHD", 1920, 1080},
                                  ZedSize{"2K", 2208, 1242},      ZedSize{"VGA", 672, 376},
                                  ZedSize{"FHD1200", 1920, 1200}, ZedSize{"SVGA", 960, 600}};

/// "SECTION:KEY" in upper case to the number.
std::map<std::string, double> ReadIni(const std::string& text) {
  std::map<std::string, double> values;
  std::istringstream lines(text);
  std::string line, section;
  while (std::getline(lines, line)) {
    std::transform(line.begin(), line.end(), line.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    const std::size_t equals = line.find('=');
    if (line.rfind('[', 0) == 0) {
      section = line.substr(1, line.find(']') - 1);
    } else if (equals != std::string::npos) {
      const std::vector<double> numbers = NumbersIn(line.substr(equals + 1));
      if (!numbers.empty()) values[section + ":" + line.substr(0, equals)] = numbers.front();
    }
  }
  return values;
}

}  // namespace

CalibrationParts ReadZedConf(const std::string& text, const std::string& where, const ImageSize& size) {
  const std::map<std::string, double> values = ReadIni(text);
  const auto value = [&](const std::string& key) {
    const auto found = values.find(key);
    if (found == values.end()) throw FileError(where + ": " + key + " is missing");
    return found->second;
  };
  const auto value_or_zero = [&](const std::string& key) {
    return values.contains(key) ? values.at(key) : 0.0;
  };
  const ZedSize* chosen = nullptr;
  for (const ZedSize& candidate : kZedSizes) {
    const bool wanted = !size || (candidate.width == size->first && candidate.height == size->second);
    if (wanted && !chosen && values.contains(std::string("LEFT_CAM_") + candidate.name + ":FX"))
      chosen = &candidate;
  }
  if (!chosen) throw FileError(where + ": holds no section of a ZED camera for this size of image");
  const std::string ending = chosen->name;

  CalibrationParts out;
  out.format = "ZED factory calibration";
  for (const auto& [side, prefix] :
       {std::pair{CameraSide::kLeft, "LEFT_CAM_"}, std::pair{CameraSide::kRight, "RIGHT_CAM_"}}) {
    const std::string section = prefix + ending;
    CameraPart part;
    part.place = where + ": " + section;
    part.side = side;
    part.width = chosen->width;
    part.height = chosen->height;
    part.lens = RawCamera{
        value(section + ":FX"),
        value(section + ":FY"),
        value(section + ":CX"),
        value(section + ":CY"),
        DistortionModel::kRadialTangential,
        {value_or_zero(section + ":K1"), value_or_zero(section + ":K2"), value_or_zero(section + ":P1"),
         value_or_zero(section + ":P2"), value_or_zero(section + ":K3")}};
    out.cameras.push_back(std::move(part));
  }
  // As Stereolabs' samples use it: Rodrigues' vector (RX, CV, RZ) and the baseline in millimetres along +x,
  // which rectifies to the same rows as p_right = R p_left - (baseline, TY, TZ).
  const Eigen::Vector3d turn(value_or_zero("STEREO:RX_" + ending), value_or_zero("STEREO:CV_" + ending),
                             value_or_zero("STEREO:RZ_" + ending));
  Eigen::Isometry3d T_right_left = Eigen::Isometry3d::Identity();
  if (turn.norm() > 1e-12)
    T_right_left.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  T_right_left.translation() =
      -kMillimetre * Eigen::Vector3d(value("STEREO:BASELINE"),
                                     value_or_zero("STEREO:TY_" + ending) + value_or_zero("STEREO:TY"),
                                     value_or_zero("STEREO:TZ_" + ending) + value_or_zero("STEREO:TZ"));
  out.T_right_left = T_right_left;
  if (!size) {
    out.notes.push_back("holds one calibration for each size of image: that of " +
                        std::to_string(chosen->width) + "x" + std::to_string(chosen->height) +
                        " is read; --size chooses another");
  }
  return out;
}

CalibrationParts ReadZedText(const std::string& text, const std::string& where) {
  // "Pinhole fx fy cx cy 0", size, "crop", size, baseline: rectified by the SDK.
  std::istringstream words(text);
  std::string model, crop;
  double fx = 0, fy = 0, cx = 0, cy = 0, omega = 0, baseline_m = 0;
  int width = 0, height = 0, out_width = 0, out_height = 0;
  words >> model >> fx >> fy >> cx >> cy >> omega >> width >> height >> crop >> out_width >> out_height >>
      baseline_m;
  if (!words || model != "Pinhole")
    throw FileError(where + ": must read Pinhole fx fy cx cy 0, a size, crop, a size and the baseline");
  if (omega != 0.0)
    throw FileError(where + ": the fifth number of Pinhole must be 0: these images are rectified");
  if (width != out_width || height != out_height)
    throw FileError(where + ": both sizes must be the same: the images are used as they are");
  CalibrationParts out;
  out.format = "ZED SDK, rectified pair";
  for (const CameraSide side : {CameraSide::kLeft, CameraSide::kRight}) {
    CameraPart part;
    part.place = where;
    part.side = side;
    part.width = width;
    part.height = height;
    part.lens = RawCamera{fx, fy, cx, cy, DistortionModel::kRadialTangential, {}};
    out.cameras.push_back(std::move(part));
  }
  out.T_right_left = Eigen::Isometry3d(Eigen::Translation3d(-baseline_m, 0, 0));
  return out;
}

}  // namespace terrace
