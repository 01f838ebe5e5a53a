// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/rig_file.h"

#include <array>
#include <charconv>

#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

constexpr const char* kFormat = "terrace-rig";
constexpr int kVersion = 1;

/// The shortest text that reads back as the same number.
std::string Exact(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string List(const std::vector<double>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + Exact(value);
  return text + "]";
}

std::string PrintPose(const std::string& key, const Eigen::Isometry3d& T) {
  std::string text = key + ":\n  [";
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      text += Exact(T.matrix()(row, column));
      if (row < 3 || column < 3) text += column < 3 ? ", " : ",\n   ";
    }
  }
  return text + "]\n";
}

std::string PrintCamera(const char* side, const RawCamera& camera) {
  return std::string(side) + ":\n  model: " + Name(camera.model) + "\n  fx: " + Exact(camera.fx) +
         "\n  fy: " + Exact(camera.fy) + "\n  cx: " + Exact(camera.cx) + "\n  cy: " + Exact(camera.cy) +
         "\n  distortion: " + List(camera.distortion) + "\n";
}

/// As it was written: no rotation is made exact twice.
Eigen::Isometry3d ExactPose(const YamlValue& value) {
  value.Pose();  // or it fails
  const std::vector<double> numbers = value.Numbers(16);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  return T;
}

}  // namespace

std::string PrintRigFile(const StereoCalibration& calibration) {
  std::string quoted;
  for (const char c : calibration.name) quoted += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
  std::string text = std::string(
                         "# A stereo rig. Pixels and metres; pixel centres at whole numbers; T_a_b maps b to "
                         "a: p_a = T_a_b p_b.\n") +
                     "format: " + kFormat + "\nversion: " + std::to_string(kVersion) + "\nname: \"" + quoted +
                     "\"\n" + "image_size: [" + std::to_string(calibration.width) + ", " +
                     std::to_string(calibration.height) + "]\n" + PrintCamera("left", calibration.left) +
                     PrintCamera("right", calibration.right) +
                     PrintPose("T_right_left", calibration.T_rawright_rawleft);
  if (calibration.T_body_rawleft) text += PrintPose("T_body_left", *calibration.T_body_rawleft);
  if (calibration.T_body_imu) text += PrintPose("T_body_imu", *calibration.T_body_imu);
  const ImuNoise& noise = calibration.imu_noise;
  return text + "imu_noise:  # densities and walks in Kalibr's units; 0: not known\n  gyro_density: " +
         Exact(noise.gyro_density) + "\n  gyro_walk: " + Exact(noise.gyro_walk) +
         "\n  accel_density: " + Exact(noise.accel_density) + "\n  accel_walk: " + Exact(noise.accel_walk) +
         "\n";
}

CalibrationParts ReadRigFile(const YamlValue& root) {
  if (root["version"].WholeNumber() != kVersion) root.Fail("version must be 1");
  CalibrationParts out;
  out.format = kFormat;
  const std::vector<YamlValue> size = root["image_size"].Items();
  if (size.size() != 2) root.Fail("image_size must be two whole numbers of pixels");
  for (const auto& [side, name] :
       {std::pair{CameraSide::kLeft, "left"}, std::pair{CameraSide::kRight, "right"}}) {
    const YamlValue camera = root[name];
    CameraPart part;
    part.place = camera.where();
    part.side = side;
    part.width = size[0].WholeNumber();
    part.height = size[1].WholeNumber();
    const std::string model_name = camera["model"].Text();
    const auto model = DistortionModelFromName(model_name);
    if (!model) camera.Fail("model " + model_name + " is not known");
    part.lens = RawCamera{camera["fx"].Number(),
                          camera["fy"].Number(),
                          camera["cx"].Number(),
                          camera["cy"].Number(),
                          *model,
                          camera["distortion"].Numbers()};
    out.cameras.push_back(std::move(part));
  }
  out.T_right_left = ExactPose(root["T_right_left"]);
  if (root.Has("T_body_left")) {
    out.cameras[0].T_common_camera = ExactPose(root["T_body_left"]);
    out.cameras[0].common = CommonFrame::kBody;
  }
  if (root.Has("T_body_imu")) out.T_common_imu = ExactPose(root["T_body_imu"]);
  if (root.Has("imu_noise")) {
    const YamlValue noise = root["imu_noise"];
    out.imu_noise = {noise.NumberOr("gyro_density", 0), noise.NumberOr("gyro_walk", 0),
                     noise.NumberOr("accel_density", 0), noise.NumberOr("accel_walk", 0)};
  }
  return out;
}

}  // namespace terrace
