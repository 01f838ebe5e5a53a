// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>

#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

constexpr double kCentimetre = 1e-2;

// ---- OAK

struct OakCamera {
  CameraPart part;
  int to_socket = -1;
  Eigen::Isometry3d T_to_camera = Eigen::Isometry3d::Identity();
};

OakCamera ReadOakCamera(const YamlValue& entry) {
  OakCamera out;
  out.part.place = entry.where();
  out.part.width = entry["width"].WholeNumber();
  out.part.height = entry["height"].WholeNumber();
  const int type = entry.Has("cameraType") ? entry["cameraType"].WholeNumber() : 0;
  std::vector<double> k = entry["distortionCoeff"].Numbers();
  if (type == 1) k.resize(std::min<std::size_t>(k.size(), 4));  // the rest of a fisheye's 14 are zeros
  if (type != 0 && type != 1) entry.Fail("cameraType must be 0 (perspective) or 1 (fisheye)");
  out.part.lens =
      LensFromMatrix(entry["intrinsicMatrix"].Matrix3(),
                     type == 1 ? DistortionModel::kEquidistant : DistortionModel::kRadialTangential, k);
  const YamlValue extrinsics = entry["extrinsics"];
  out.to_socket = extrinsics["toCameraSocket"].WholeNumber();
  if (out.to_socket < 0) return out;
  const YamlValue t = extrinsics["translation"];
  const auto pose =
      PoseFrom(extrinsics["rotationMatrix"].Matrix3(),
               kCentimetre * Eigen::Vector3d(t["x"].Number(), t["y"].Number(), t["z"].Number()));
  if (!pose) extrinsics.Fail("rotationMatrix must be a rotation");
  out.T_to_camera = *pose;
  return out;
}

/// Pose of a camera in the one at the end of its chain; none when the chain is broken.
std::optional<Eigen::Isometry3d> ToEndOfChain(const std::map<int, OakCamera>& cameras, int socket, int* end) {
  Eigen::Isometry3d T_here_camera = Eigen::Isometry3d::Identity();
  for (std::size_t steps = 0; steps <= cameras.size(); ++steps) {
    const OakCamera& camera = cameras.at(socket);
    if (camera.to_socket < 0) {
      *end = socket;
      return T_here_camera;
    }
    if (!cameras.contains(camera.to_socket)) return std::nullopt;
    T_here_camera = camera.T_to_camera * T_here_camera;
    socket = camera.to_socket;
  }
  return std::nullopt;
}

// ---- RealSense

/// Its SDK's intrinsics: width, height, ppx, ppy, fx, fy, model, coeffs.
CameraPart ReadRealSenseLens(const YamlValue& value, const std::string& name) {
  CameraPart part;
  part.place = value.where();
  part.side = SideOfName(name);
  part.width = value["width"].WholeNumber();
  part.height = value["height"].WholeNumber();
  std::string model = value.TextOr("model", "brown_conrady");
  model = model.substr(model.rfind('.') + 1);
  std::vector<double> k = value.Has("coeffs") ? value["coeffs"].Numbers() : std::vector<double>();
  const bool straight = std::all_of(k.begin(), k.end(), [](double c) { return c == 0.0; });
  if (straight) {
    model = "none";
    k.clear();
  }
  const auto known = ModelOfAnyName(model);
  if (!known) value.Fail("model " + model + " with coefficients is none that can be used");
  if (*known == DistortionModel::kEquidistant) k.resize(4);
  if (*known == DistortionModel::kFieldOfView) k.resize(1);
  part.lens = RawCamera{
      value["fx"].Number(), value["fy"].Number(), value["ppx"].Number(), value["ppy"].Number(), *known, k};
  return part;
}

/// Its SDK's extrinsics: nine numbers by columns, three in metres.
std::optional<Eigen::Isometry3d> RealSensePose(const std::vector<double>& by_columns,
                                               const std::vector<double>& t) {
  if (by_columns.size() != 9 || t.size() != 3) return std::nullopt;
  return PoseFrom(Eigen::Map<const Eigen::Matrix3d>(by_columns.data()), {t[0], t[1], t[2]});
}

/// Extrinsics are printed as those from one stream to another; whoever wrote them from right to left is
/// turned round.
Eigen::Isometry3d RightFromLeft(const Eigen::Isometry3d& T_to_from, bool from_left) {
  return from_left ? T_to_from : T_to_from.inverse();
}

std::string FirstLineWith(const std::string& block, const std::string& word) {
  const std::size_t at = block.find(word);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + word.size();
  return block.substr(begin, block.find('\n', begin) - begin);
}

double NumberAfter(const std::string& block, const std::string& word, const std::string& where) {
  const std::vector<double> numbers = NumbersIn(FirstLineWith(block, word));
  if (numbers.empty()) throw FileError(where + ": no number after " + word);
  return numbers.front();
}

}  // namespace

CalibrationParts ReadOak(const YamlValue& root) {
  CalibrationParts out;
  out.format = "OAK (depthai) calibration";
  std::map<int, OakCamera> cameras;
  for (const YamlValue& item : root["cameraData"].Items()) {
    const std::vector<YamlValue> pair = item.Items();
    if (pair.size() != 2) item.Fail("must be a socket and a camera");
    if (pair[1]["width"].WholeNumber() == 0) continue;  // a socket without calibration
    cameras.emplace(pair[0].WholeNumber(), ReadOakCamera(pair[1]));
  }
  // Which two are left and right is said beside them; else sockets 1 and 2 (CAM_B and CAM_C).
  int left = 1, right = 2;
  if (root.Has("stereoRectificationData")) {
    const YamlValue stereo = root["stereoRectificationData"];
    left = stereo["leftCameraSocket"].WholeNumber();
    right = stereo["rightCameraSocket"].WholeNumber();
    if (left < 0 || right < 0) left = 1, right = 2;
  }
  if (!cameras.contains(left) || !cameras.contains(right))
    root.Fail("cameraData holds no left and right camera");
  int left_end = -1, right_end = -1;
  const auto T_left = ToEndOfChain(cameras, left, &left_end);
  const auto T_right = ToEndOfChain(cameras, right, &right_end);
  for (const auto& [side, socket, T] :
       {std::tuple{CameraSide::kLeft, left, T_left}, std::tuple{CameraSide::kRight, right, T_right}}) {
    CameraPart part = cameras.at(socket).part;
    part.side = side;
    if (left_end == right_end) part.T_common_camera = T;
    out.cameras.push_back(std::move(part));
  }
  return out;
}

CalibrationParts ReadRealSense(const YamlValue& root) {
  CalibrationParts out;
  out.format = "RealSense calibration";
  const std::function<void(const YamlValue&, const std::string&)> search = [&](const YamlValue& value,
                                                                               const std::string& name) {
    if (value.Has("ppx") && value.Has("fx")) {
      // The colour camera and the depth image are no part of the pair.
      if (SideOfName(name) != CameraSide::kUnknown) out.cameras.push_back(ReadRealSenseLens(value, name));
      return;
    }
    if (value.Has("rotation") && value.Has("translation")) {
      const std::size_t to = name.find("to");
      const CameraSide from = SideOfName(to == std::string::npos ? "left" : name.substr(0, to));
      if (from == CameraSide::kUnknown || out.T_right_left) return;
      const auto pose = RealSensePose(value["rotation"].Numbers(9), value["translation"].Numbers(3));
      if (!pose) value.Fail("must be a rotation and a translation");
      out.T_right_left = RightFromLeft(*pose, from == CameraSide::kLeft);
      return;
    }
    for (const auto& [key, member] : value.Members())
      search(member, member.IsMap() && key == "intrinsics" ? name : key);
  };
  search(root, "");
  if (out.cameras.size() < 2) root.Fail("holds no intrinsics of left and right (infrared 1 and 2)");
  return out;
}

CalibrationParts ReadRealSenseText(const std::string& text, const std::string& where, const ImageSize& size) {
  CalibrationParts out;
  out.format = "RealSense rs-enumerate-devices";
  std::map<std::pair<int, int>, std::map<std::string, CameraPart>> by_size;
  std::istringstream lines(text);
  const std::string kIntrinsic = "Intrinsic of \"";
  for (std::size_t at = text.find(kIntrinsic); at != std::string::npos; at = text.find(kIntrinsic, at + 1)) {
    const std::string block = text.substr(at, text.find("Intrinsic of", at + 1) - at);
    const std::size_t name_begin = kIntrinsic.size();
    const std::string name = block.substr(name_begin, block.find('"', name_begin) - name_begin);
    if (name != "Infrared 1" && name != "Infrared 2") continue;
    CameraPart part;
    part.place = where + ": " + name;
    part.side = SideOfName(name);
    part.width = static_cast<int>(NumberAfter(block, "Width:", where));
    part.height = static_cast<int>(NumberAfter(block, "Height:", where));
    const std::vector<double> k = NumbersIn(FirstLineWith(block, "Coeffs:"));
    if (std::any_of(k.begin(), k.end(), [](double c) { return c != 0.0; }))
      throw FileError(part.place +
                      ": has distortion coefficients; the infrared images of this SDK are rectified");
    part.lens = RawCamera{NumberAfter(block, "Fx:", where),   NumberAfter(block, "Fy:", where),
                          NumberAfter(block, "PPX:", where),  NumberAfter(block, "PPY:", where),
                          DistortionModel::kRadialTangential, {}};
    by_size[{part.width, part.height}][name] = part;
  }
  const auto chosen = size ? by_size.find(*size) : by_size.find({848, 480});
  const auto found = chosen == by_size.end() && !size ? by_size.begin() : chosen;
  if (found == by_size.end())
    throw FileError(where + ": holds no intrinsics of the infrared pair in this size");
  for (const auto& [name, part] : found->second) out.cameras.push_back(part);
  if (!size) {
    out.notes.push_back("holds one calibration for each size of image: that of " +
                        std::to_string(found->first.first) + "x" + std::to_string(found->first.second) +
                        " is read; --size chooses another");
  }
  for (const bool from_left : {true, false}) {
    const std::string heading = from_left ? "Extrinsic from \"Infrared 1\"" : "Extrinsic from \"Infrared 2\"";
    for (std::size_t at = text.find(heading); at != std::string::npos && !out.T_right_left;
         at = text.find(heading, at + 1)) {
      const std::string block = text.substr(at, text.find("Extrinsic from", at + 1) - at);
      const std::string first_line = block.substr(0, block.find('\n'));
      const bool to_other = first_line.find(from_left ? "\"Infrared 2\"" : "\"Infrared 1\"",
                                            heading.size()) != std::string::npos;
      const std::size_t t_at = block.find("Translation Vector:");
      const std::size_t r_at = block.find("Rotation Matrix:");
      if (!to_other || t_at == std::string::npos || r_at == std::string::npos) continue;
      std::vector<double> R = NumbersIn(block.substr(r_at, t_at - r_at));  // printed by rows
      std::vector<double> t = NumbersIn(block.substr(t_at));
      if (R.size() < 9 || t.size() < 3) continue;
      const auto pose = PoseFrom(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()),
                                 {t[0], t[1], t[2]});
      if (pose) out.T_right_left = RightFromLeft(*pose, from_left);
    }
  }
  return out;
}

CalibrationParts ReadEcon(const YamlValue& root) {
  CalibrationParts out;
  out.format = "e-con camera file";
  for (const CameraSide side : {CameraSide::kLeft, CameraSide::kRight}) {
    const std::string name = side == CameraSide::kLeft ? "Camera1" : "Camera2";
    const auto number = [&](const char* key) { return root[name + "." + key].Number(); };
    const auto number_or_zero = [&](const char* key) { return root.NumberOr(name + "." + key, 0.0); };
    CameraPart part;
    part.place = root.where() + ": " + name;
    part.side = side;
    part.width = root["Camera.image_width"].WholeNumber();
    part.height = root["Camera.image_height"].WholeNumber();
    part.lens = RawCamera{number("fx"),
                          number("fy"),
                          number("cx"),
                          number("cy"),
                          DistortionModel::kRadialTangential,
                          {number_or_zero("k1"), number_or_zero("k2"), number_or_zero("p1"),
                           number_or_zero("p2"), number_or_zero("k3")}};
    out.cameras.push_back(std::move(part));
  }
  constexpr double kMillimetre = 1e-3;
  const double baseline_m = kMillimetre * root["Camera.baseline"].Number();
  out.T_right_left = Eigen::Isometry3d(Eigen::Translation3d(-baseline_m, 0, 0));
  out.notes.push_back(
      "says nothing about how the cameras are turned against each other: taken for parallel; "
      "--check measures it");
  return out;
}

}  // namespace terrace
