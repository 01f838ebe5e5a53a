// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/calibration_file.h"

#include "datasets/calibration_assembly.h"
#include "datasets/calibration_formats.h"
#include "datasets/folder_sequence.h"
#include "datasets/opencv_xml.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKnownFormats =
    "must be a calibration of Kalibr, OpenCV, ROS, EuRoC, KITTI, camodocal or VINS, Basalt, ZED, RealSense, "
    "OAK, e-con, "
    "or a rig file of ours";

CalibrationParts ReadTree(const YamlValue& root, const fs::path& path) {
  if (!root.IsMap()) root.Fail(kKnownFormats);
  const auto has = [&](const char* key) { return root.Has(key); };
  if (root.TextOr("format", "") == "terrace-rig") return ReadRigFile(root);
  if (has("value0")) return ReadBasalt(root);
  if (has("cameraData")) return ReadOak(root);
  if (has("cam0") && root["cam0"].IsMap()) return ReadKalibr(root);
  if (has("body_T_cam0")) return ReadVinsConfig(root, path.parent_path());
  if (has("model_type")) return ReadCamodocal(root);
  if (has("T_BS")) return ReadEurocSensor(root);
  if (has("Camera1.fx")) return ReadEcon(root);
  const bool ros_file = has("camera_matrix") && (has("camera_name") || has("projection_matrix"));
  const bool ros_message = has("distortion_model") && (has("K") || has("k"));
  if (ros_file || ros_message) return ReadRosCameraInfo(root);
  if (path.extension() == ".json" && !has("M1") && !has("K1")) return ReadRealSense(root);
  return ReadOpenCv(root);
}

CalibrationParts ReadOneFile(const fs::path& path, const ImageSize& size) {
  constexpr std::uintmax_t kMaxBytes = 4 << 20;
  const std::string where = path.string();
  const std::string text = ReadTextFile(path, kMaxBytes);
  const auto holds = [&](const char* words) { return text.find(words) != std::string::npos; };
  if (text.rfind("# oST", 0) == 0) return ReadRosOst(text, where);
  if (text.rfind("Pinhole ", 0) == 0) return ReadZedText(text, where);
  if (holds("[LEFT_CAM_")) return ReadZedConf(text, where, size);
  if (holds("Intrinsic of \"")) return ReadRealSenseText(text, where, size);
  if (holds("P_rect_0") && holds("S_0")) return ReadKittiRaw(text, where, size);
  if (text.rfind("P0:", 0) == 0) return ReadKittiOdometry(text, where);
  if (holds("<opencv_storage")) return ReadTree(ParseYaml(YamlFromOpenCvXml(text, where), where), path);
  return ReadTree(ParseYaml(text, where), path);
}

/// A folder of a recording stands for its calibration files.
std::vector<fs::path> FilesOf(const std::vector<fs::path>& paths) {
  std::vector<fs::path> files;
  for (const fs::path& path : paths) {
    if (fs::is_directory(path / "mav0")) {
      for (const char* camera : {"cam0", "cam1"}) files.push_back(path / "mav0" / camera / "sensor.yaml");
    } else if (fs::is_directory(path) && fs::exists(path / "calib.txt")) {
      files.push_back(path / "calib.txt");
    } else {
      files.push_back(path);
    }
  }
  return files;
}

}  // namespace

RigReading ReadCalibrationFiles(const std::vector<fs::path>& paths, const RigOptions& options) {
  std::vector<CalibrationParts> parts;
  std::vector<std::string> names, problems;
  for (const fs::path& path : FilesOf(paths)) {
    try {
      parts.push_back(ReadOneFile(path, options.size));
      names.push_back(path.string());
    } catch (const FileError& error) {
      problems.push_back(error.what());
    } catch (const YAML::Exception& error) {
      problems.push_back(path.string() + ": " + error.what());
    }
  }
  ThrowIfAny(problems);
  return AssembleRig(std::move(parts), names, options);
}

StereoCalibration ReadRig(const std::vector<fs::path>& files, std::vector<std::string>* notes,
                          const RigOptions& options) {
  RigReading reading = ReadCalibrationFiles(files, options);
  std::vector<std::string> problems = reading.problems;
  const std::string name = files.empty() ? "calibration" : files.front().string();
  for (const std::string& missing : reading.missing)
    problems.push_back(name + ": is no rig yet, missing: " + missing);
  ThrowIfAny(problems);
  for (const std::string& note : reading.notes) notes->push_back(name + ": " + note);
  return std::move(*reading.rig);
}

std::vector<fs::path> SplitFileList(const std::string& text) {
  std::vector<fs::path> files;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::size_t first = text.find_first_not_of(' ', begin);
    if (first < end) files.emplace_back(text.substr(first, text.find_last_not_of(' ', end - 1) - first + 1));
    begin = end + 1;
  }
  return files;
}

}  // namespace terrace
