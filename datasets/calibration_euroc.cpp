// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

/// OCamCalib's polynomial as Kimera writes it: the ray of a point m about the centre, in pixels, is (m, a0 +
/// a1 |m|
/// + ... + a4 |m|^4), the pixel [1 d; e c] m.
RawCamera PolynomialLens(const YamlValue& root) {
  const std::vector<double> a = root["distortion_coefficients"].Numbers(5);
  const std::vector<double> affine = root["omni_affine"].Numbers(3);
  const std::vector<double> centre = root["omni_distortion_center"].Numbers(2);
  if (!(a[0] > 0.0)) root.Fail("distortion_coefficients must begin with a positive focal length");
  const double f = a[0];
  return {f,
          f,
          centre[0],
          centre[1],
          DistortionModel::kPolynomial,
          {a[1], a[2] * f, a[3] * f * f, a[4] * f * f * f, affine[0], affine[1], affine[2]}};
}

}  // namespace

CalibrationParts ReadEurocSensor(const YamlValue& root) {
  CalibrationParts out;
  out.format = "EuRoC sensor.yaml";
  CameraPart part;
  part.place = root.where();
  part.side = SideOfName(root.TextOr("camera_id", ""));
  const std::vector<YamlValue> size = root["resolution"].Items();
  if (size.size() != 2) root.Fail("resolution must be two whole numbers of pixels");
  part.width = size[0].WholeNumber();
  part.height = size[1].WholeNumber();
  const std::string camera_model = root.TextOr("camera_model", "pinhole");
  if (camera_model == "omni" && root.Has("omni_distortion_center")) {
    part.lens = PolynomialLens(root);
  } else if (camera_model == "pinhole") {
    const std::string name = root.TextOr("distortion_model", "none");
    const auto model = ModelOfAnyName(name);
    if (!model)
      root.Fail("distortion_model is " + name + ", must be radial-tangential, equidistant, fov or none");
    const std::vector<double> f = root["intrinsics"].Numbers(4);
    part.lens = RawCamera{
        f[0], f[1],   f[2],
        f[3], *model, name == "none" ? std::vector<double>() : root["distortion_coefficients"].Numbers()};
  } else {
    root.Fail("camera_model is " + camera_model + ", must be pinhole, or omni with omni_distortion_center");
  }
  part.T_common_camera = root["T_BS"].Pose();
  part.common = CommonFrame::kBody;
  out.cameras.push_back(std::move(part));
  return out;
}

}  // namespace terrace
