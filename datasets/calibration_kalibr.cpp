// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

/// Kalibr's camera and distortion models (github.com/ethz-asl/kalibr, wiki "supported models").
RawCamera KalibrLens(const YamlValue& camera) {
  const std::string model = camera.TextOr("camera_model", "pinhole");
  const std::string distortion = camera.TextOr("distortion_model", "none");
  const std::vector<double> k =
      camera.Has("distortion_coeffs") ? camera["distortion_coeffs"].Numbers() : std::vector<double>();
  const YamlValue intrinsics = camera["intrinsics"];
  if (model == "pinhole") {
    const auto lens_model = ModelOfAnyName(distortion);
    if (!lens_model)
      camera.Fail("distortion_model is " + distortion + ", must be radtan, equidistant, fov or none");
    const std::vector<double> f = intrinsics.Numbers(4);
    return {f[0], f[1], f[2], f[3], *lens_model, distortion == "none" ? std::vector<double>() : k};
  }
  if (model == "omni") {
    const std::vector<double> f = intrinsics.Numbers(5);
    std::vector<double> all = {f[0], 0, 0, 0, 0};
    if (distortion == "radtan" && k.size() == 4) {
      std::copy(k.begin(), k.end(), all.begin() + 1);
    } else if (distortion != "none") {
      camera.Fail("an omni camera has distortion_model radtan with 4 coefficients or none");
    }
    return {f[1], f[2], f[3], f[4], DistortionModel::kOmni, all};
  }
  if (model == "ds" || model == "eucm") {
    const std::vector<double> f = intrinsics.Numbers(6);
    if (distortion != "none") camera.Fail("distortion_model of a " + model + " camera must be none");
    return {f[2],
            f[3],
            f[4],
            f[5],
            model == "ds" ? DistortionModel::kDoubleSphere : DistortionModel::kExtendedUnified,
            {f[0], f[1]}};
  }
  camera.Fail("camera_model is " + model + ", must be pinhole, omni, ds or eucm");
}

}  // namespace

CalibrationParts ReadKalibr(const YamlValue& root) {
  CalibrationParts out;
  out.format = "Kalibr camchain";
  std::optional<Eigen::Isometry3d> T_first_before = Eigen::Isometry3d::Identity();
  for (int i = 0; root.Has("cam" + std::to_string(i)); ++i) {
    const YamlValue camera = root["cam" + std::to_string(i)];
    CameraPart part;
    part.place = camera.where();
    if (camera.Has("intrinsics")) part.lens = KalibrLens(camera);
    if (camera.Has("resolution")) {
      const std::vector<YamlValue> size = camera["resolution"].Items();
      if (size.size() != 2) camera["resolution"].Fail("must be two whole numbers of pixels");
      part.width = size[0].WholeNumber();
      part.height = size[1].WholeNumber();
    }
    // The chain of cameras, for what has no IMU.
    if (i > 0) {
      if (camera.Has("T_cn_cnm1") && T_first_before) {
        T_first_before = *T_first_before * camera["T_cn_cnm1"].Pose().inverse();
      } else {
        T_first_before.reset();
      }
    }
    if (camera.Has("T_cam_imu") || camera.Has("T_imu_cam")) {
      part.T_common_camera =
          camera.Has("T_imu_cam") ? camera["T_imu_cam"].Pose() : camera["T_cam_imu"].Pose().inverse();
      part.common = CommonFrame::kImu;
    } else if (T_first_before) {
      part.T_common_camera = *T_first_before;
    }
    if (camera.Has("timeshift_cam_imu") && !out.imu_minus_camera_s)
      out.imu_minus_camera_s = camera["timeshift_cam_imu"].Number();
    out.cameras.push_back(std::move(part));
  }
  return out;
}

}  // namespace terrace
