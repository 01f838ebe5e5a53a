// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

/// Puts a camera into the rectified axes of the left one: ROS gives R (rectified from raw) and P, whose
/// fourth column holds fx and fy times where the left camera lies.
void PlaceByRectification(const Eigen::Matrix3d& R, const std::vector<double>& P, CameraPart* part) {
  if (P[0] <= 0.0 || P[5] <= 0.0) return;                  // not calibrated as stereo
  const Eigen::Vector3d t(P[3] / P[0], P[7] / P[5], 0.0);  // p_rectified = p_common + t
  const auto T_rectified_camera = PoseFrom(R, Eigen::Vector3d::Zero());
  if (!T_rectified_camera) return;
  part->T_common_camera = Eigen::Translation3d(-t) * *T_rectified_camera;
}

constexpr const char* kRosFormat = "ROS camera_info";

}  // namespace

CalibrationParts ReadRosCameraInfo(const YamlValue& root) {
  // The file of camera_calibration, or the message of ROS 1 or 2.
  const auto either = [&](const char* a, const char* b, const char* c) {
    for (const char* key : {a, b}) {
      if (root.Has(key)) return root[key];
    }
    return root[c];
  };
  CalibrationParts out;
  out.format = kRosFormat;
  out.unit_m.reset();  // the squares of the board may have been given in anything
  CameraPart part;
  part.place = root.where();
  part.side = SideOfName(root.TextOr("camera_name", ""));
  part.width = (root.Has("image_width") ? root["image_width"] : root["width"]).WholeNumber();
  part.height = (root.Has("image_height") ? root["image_height"] : root["height"]).WholeNumber();
  const std::string name = root.TextOr("distortion_model", "plumb_bob");
  const auto model = ModelOfAnyName(name);
  if (!model)
    root.Fail("distortion_model is " + name + ", must be plumb_bob, rational_polynomial or equidistant");
  part.lens = LensFromMatrix(either("camera_matrix", "K", "k").Matrix3(), *model,
                             either("distortion_coefficients", "D", "d").Numbers());
  const bool stereo =
      (root.Has("rectification_matrix") && root.Has("projection_matrix")) || root.Has("P") || root.Has("p");
  if (stereo) {
    PlaceByRectification(either("rectification_matrix", "R", "r").Matrix3(),
                         either("projection_matrix", "P", "p").Numbers(12), &part);
  }
  out.cameras.push_back(std::move(part));
  return out;
}

CalibrationParts ReadRosOst(const std::string& text, const std::string& where) {
  CalibrationParts out;
  out.format = "ROS ost.txt";
  out.unit_m.reset();
  // Each camera is a section [name] with headings in words and numbers below them.
  std::string name, heading;
  std::map<std::string, std::vector<double>> image, camera;
  const auto finish = [&] {
    if (camera.empty()) return;
    const auto numbers = [&](const char* key, std::size_t least, std::size_t most) {
      const std::vector<double>& found = camera[key];
      if (found.size() < least || found.size() > most)
        throw FileError(where + ": [" + name + "] " + key + " must hold " + std::to_string(least) +
                        " numbers");
      return found;
    };
    CameraPart part;
    part.place = where + ": " + name;
    part.side = SideOfName(name);
    part.width = image["width"].empty() ? 0 : static_cast<int>(image["width"][0]);
    part.height = image["height"].empty() ? 0 : static_cast<int>(image["height"][0]);
    const std::vector<double> K = numbers("camera matrix", 9, 9);
    part.lens = LensFromMatrix(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(K.data()),
                               DistortionModel::kRadialTangential, numbers("distortion", 4, 14));
    if (!camera["rectification"].empty() && !camera["projection"].empty()) {
      const std::vector<double> R = numbers("rectification", 9, 9);
      PlaceByRectification(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()),
                           numbers("projection", 12, 12), &part);
    }
    out.cameras.push_back(std::move(part));
    camera.clear();
  };
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    const std::vector<double> found = NumbersIn(line);
    if (line[0] == '[') {
      finish();
      name = line.substr(1, line.find(']') - 1);
    } else if (found.empty()) {
      heading = line.substr(0, line.find_last_not_of(' ') + 1);
    } else {
      std::vector<double>& values = name == "image" ? image[heading] : camera[heading];
      values.insert(values.end(), found.begin(), found.end());
    }
  }
  finish();
  if (out.cameras.empty()) throw FileError(where + ": holds no camera");
  return out;
}

}  // namespace terrace
