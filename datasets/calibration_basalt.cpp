// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

/// Basalt's camera types (gitlab.com/VladyslavUsenko/basalt-headers, camera/).
RawCamera BasaltLens(const YamlValue& camera) {
  const std::string type = camera["camera_type"].Text();
  const YamlValue v = camera["intrinsics"];
  const auto lens = [&](DistortionModel model, std::vector<double> k) {
    return RawCamera{v["fx"].Number(), v["fy"].Number(), v["cx"].Number(), v["cy"].Number(), model,
                     std::move(k)};
  };
  const auto n = [&](const char* key) { return v[key].Number(); };
  if (type == "ds") return lens(DistortionModel::kDoubleSphere, {n("xi"), n("alpha")});
  if (type == "eucm") return lens(DistortionModel::kExtendedUnified, {n("alpha"), n("beta")});
  if (type == "ucm") return lens(DistortionModel::kExtendedUnified, {n("alpha"), 1.0});
  if (type == "kb4") return lens(DistortionModel::kEquidistant, {n("k1"), n("k2"), n("k3"), n("k4")});
  if (type == "fov") return lens(DistortionModel::kFieldOfView, {n("w")});
  if (type == "pinhole") return lens(DistortionModel::kRadialTangential, {});
  if (type == "pinhole-radtan8") {
    return lens(DistortionModel::kRadialTangential,
                {n("k1"), n("k2"), n("p1"), n("p2"), n("k3"), n("k4"), n("k5"), n("k6")});
  }
  camera.Fail("camera_type is " + type + ", must be ds, eucm, ucm, kb4, fov, pinhole or pinhole-radtan8");
}

Eigen::Isometry3d BasaltPose(const YamlValue& v) {
  Eigen::Quaterniond q(v["qw"].Number(), v["qx"].Number(), v["qy"].Number(), v["qz"].Number());
  if (std::abs(q.norm() - 1.0) > 1e-2) v.Fail("qx, qy, qz, qw must be a unit quaternion");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(v["px"].Number(), v["py"].Number(), v["pz"].Number());
  return pose;
}

/// Basalt writes one number, or one an axis.
double LargestOf(const YamlValue& root, const char* key) {
  if (!root.Has(key)) return 0.0;
  double largest = 0.0;
  if (!root[key].IsList()) return root[key].Number();
  for (const double value : root[key].Numbers()) largest = std::max(largest, value);
  return largest;
}

}  // namespace

CalibrationParts ReadBasalt(const YamlValue& file) {
  const YamlValue root = file["value0"];
  CalibrationParts out;
  out.format = "Basalt calibration";
  const std::vector<YamlValue> lenses = root["intrinsics"].Items();
  const std::vector<YamlValue> poses = root["T_imu_cam"].Items();
  const std::vector<YamlValue> sizes = root["resolution"].Items();
  if (poses.size() != lenses.size() || sizes.size() != lenses.size())
    root.Fail("intrinsics, T_imu_cam and resolution must have one entry a camera");
  for (std::size_t i = 0; i < lenses.size(); ++i) {
    CameraPart part;
    part.place = lenses[i].where();
    part.lens = BasaltLens(lenses[i]);
    part.T_common_camera = BasaltPose(poses[i]);
    part.common = CommonFrame::kImu;
    const std::vector<YamlValue> size = sizes[i].Items();
    if (size.size() != 2) sizes[i].Fail("must be two whole numbers of pixels");
    part.width = size[0].WholeNumber();
    part.height = size[1].WholeNumber();
    out.cameras.push_back(std::move(part));
  }
  out.imu_noise = {LargestOf(root, "gyro_noise_std"), LargestOf(root, "gyro_bias_std"),
                   LargestOf(root, "accel_noise_std"), LargestOf(root, "accel_bias_std")};
  if (root.Has("cam_time_offset_ns")) out.imu_minus_camera_s = 1e-9 * root["cam_time_offset_ns"].Number();
  return out;
}

}  // namespace terrace
