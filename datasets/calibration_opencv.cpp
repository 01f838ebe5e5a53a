// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <map>

#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

/// Programs agree on what to store and not on its name: names are compared without case and marks.
class OpenCvKeys {
 public:
  explicit OpenCvKeys(const YamlValue& root) {
    for (const auto& [name, value] : root.Members()) {
      std::string plain;
      for (const char c : name) {
        if (std::isalnum(static_cast<unsigned char>(c)))
          plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      }
      values_.emplace(plain, value);
    }
  }

  const YamlValue* Find(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      const auto found = values_.find(name);
      if (found != values_.end()) return &found->second;
    }
    return nullptr;
  }

 private:
  std::map<std::string, YamlValue> values_;
};

RawCamera LensOf(const YamlValue& K, const YamlValue* D, bool fisheye) {
  return LensFromMatrix(K.Matrix3(),
                        fisheye ? DistortionModel::kEquidistant : DistortionModel::kRadialTangential,
                        D ? D->Numbers() : std::vector<double>());
}

/// A rotation as a matrix, or as Rodrigues' vector.
Eigen::Matrix3d RotationOf(const YamlValue& value) {
  const std::vector<double> numbers = value.Numbers();
  if (numbers.size() == 9) return value.Matrix3();
  if (numbers.size() != 3) value.Fail("must be 9 numbers, or 3 of a rotation vector");
  const Eigen::Vector3d axis(numbers[0], numbers[1], numbers[2]);
  const double angle = axis.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, axis / angle).toRotationMatrix();
}

void ReadSize(const OpenCvKeys& keys, CalibrationParts* out) {
  const YamlValue* width = keys.Find({"imagewidth", "width"});
  const YamlValue* height = keys.Find({"imageheight", "height"});
  const YamlValue* size = keys.Find({"imagesize", "size", "resolution"});
  for (CameraPart& part : out->cameras) {
    if (width && height) {
      part.width = width->WholeNumber();
      part.height = height->WholeNumber();
    } else if (size) {
      const std::vector<double> numbers = size->Numbers(2);
      part.width = static_cast<int>(numbers[0]);
      part.height = static_cast<int>(numbers[1]);
    }
  }
}

}  // namespace

CalibrationParts ReadOpenCv(const YamlValue& root) {
  const OpenCvKeys keys(root);
  CalibrationParts out;
  out.format = "OpenCV file storage";
  out.unit_m.reset();
  const YamlValue* flag = keys.Find({"fisheyemodel", "fisheye"});
  const bool fisheye = flag && (flag->Text() == "1" || flag->Text() == "true");
  const YamlValue* K1 = keys.Find({"m1", "k1", "cameramatrix1", "cameramatrixleft", "leftcameramatrix", "kl",
                                   "lk", "kleft", "leftk", "cameramatrixl", "mtxl", "k0"});
  const YamlValue* K2 = keys.Find({"m2", "k2", "cameramatrix2", "cameramatrixright", "rightcameramatrix",
                                   "kr", "rk", "kright", "rightk", "cameramatrixr", "mtxr"});
  const YamlValue* D1 =
      keys.Find({"d1", "distcoeffs1", "distcoeffsleft", "leftdistcoeffs", "dl", "ld", "dleft", "leftd",
                 "distcoeffsl", "distl", "distortioncoefficients1", "distortionleft"});
  const YamlValue* D2 =
      keys.Find({"d2", "distcoeffs2", "distcoeffsright", "rightdistcoeffs", "dr", "rd", "dright", "rightd",
                 "distcoeffsr", "distr", "distortioncoefficients2", "distortionright"});
  const YamlValue* K = keys.Find({"cameramatrix", "k", "m", "intrinsicmatrix", "mtx"});
  const YamlValue* D = keys.Find({"distortioncoefficients", "distcoeffs", "d", "distortion", "dist"});
  if (K1 && K2) {
    for (const auto& [side, matrix, distortion] :
         {std::tuple{CameraSide::kLeft, K1, D1}, std::tuple{CameraSide::kRight, K2, D2}}) {
      CameraPart part;
      part.place = matrix->where();
      part.side = side;
      part.lens = LensOf(*matrix, distortion, fisheye);
      out.cameras.push_back(std::move(part));
    }
  } else if (K) {
    CameraPart part;
    part.place = root.where();
    part.lens = LensOf(*K, D, fisheye);
    out.cameras.push_back(std::move(part));
  }
  ReadSize(keys, &out);
  const YamlValue* R = keys.Find({"r", "rotation", "rotationmatrix", "rot"});
  const YamlValue* T = keys.Find({"t", "translation", "translationvector", "trans"});
  if (R && T) {
    const std::vector<double> t = T->Numbers(3);
    out.T_right_left = PoseFrom(RotationOf(*R), {t[0], t[1], t[2]});
    if (!out.T_right_left) R->Fail("must be a rotation");
  }
  if (out.cameras.empty() && !out.T_right_left)
    root.Fail("holds neither camera matrices (as M1 and M2, or camera_matrix) nor R and T");
  return out;
}

}  // namespace terrace
