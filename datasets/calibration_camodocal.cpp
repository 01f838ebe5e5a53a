// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/calibration_formats.h"

namespace terrace {
namespace {

/// camodocal's lens models, as github.com/hengli/camodocal and VINS write them.
RawCamera CamodocalLens(const YamlValue& root) {
  const std::string type = root["model_type"].Text();
  const YamlValue projection = root["projection_parameters"];
  const auto number = [&](const char* group, const char* key) { return root[group][key].Number(); };
  if (type == "KANNALA_BRANDT") {
    return {projection["mu"].Number(),
            projection["mv"].Number(),
            projection["u0"].Number(),
            projection["v0"].Number(),
            DistortionModel::kEquidistant,
            {projection["k2"].Number(), projection["k3"].Number(), projection["k4"].Number(),
             projection["k5"].Number()}};
  }
  const char* const group = "distortion_parameters";
  const std::vector<double> k = {number(group, "k1"), number(group, "k2"), number(group, "p1"),
                                 number(group, "p2")};
  if (type == "PINHOLE") {
    return {projection["fx"].Number(), projection["fy"].Number(),          projection["cx"].Number(),
            projection["cy"].Number(), DistortionModel::kRadialTangential, k};
  }
  if (type == "MEI") {
    return {projection["gamma1"].Number(), projection["gamma2"].Number(),
            projection["u0"].Number(),     projection["v0"].Number(),
            DistortionModel::kOmni,        {number("mirror_parameters", "xi"), k[0], k[1], k[2], k[3]}};
  }
  root.Fail("model_type is " + type + ", must be PINHOLE, MEI or KANNALA_BRANDT");
}

}  // namespace

CalibrationParts ReadCamodocal(const YamlValue& root) {
  CalibrationParts out;
  out.format = "camodocal camera";
  CameraPart part;
  part.place = root.where();
  part.side = SideOfName(root.TextOr("camera_name", ""));
  part.width = root["image_width"].WholeNumber();
  part.height = root["image_height"].WholeNumber();
  part.lens = CamodocalLens(root);
  out.cameras.push_back(std::move(part));
  return out;
}

CalibrationParts ReadVinsConfig(const YamlValue& root, const std::filesystem::path& folder) {
  CalibrationParts out;
  out.format = "VINS configuration";
  for (int i = 0; i < 2; ++i) {
    const std::string index = std::to_string(i);
    CameraPart part;
    const std::string file = root.TextOr("cam" + index + "_calib", "");
    if (!file.empty() && std::filesystem::exists(folder / file)) {
      const std::string where = (folder / file).string();
      part = ReadCamodocal(ParseYaml(ReadTextFile(where), where)).cameras.front();
    } else {
      part.place = root.where() + ": cam" + index;
      part.width = root.Has("image_width") ? root["image_width"].WholeNumber() : 0;
      part.height = root.Has("image_height") ? root["image_height"].WholeNumber() : 0;
    }
    part.side = i == 0 ? CameraSide::kLeft : CameraSide::kRight;
    if (root.Has("body_T_cam" + index)) {
      part.T_common_camera = root["body_T_cam" + index].Pose();
      part.common = CommonFrame::kImu;  // VINS calls its IMU body
    }
    out.cameras.push_back(std::move(part));
  }
  out.imu_noise = {root.NumberOr("gyr_n", 0), root.NumberOr("gyr_w", 0), root.NumberOr("acc_n", 0),
                   root.NumberOr("acc_w", 0)};
  if (root.Has("td")) out.imu_minus_camera_s = root["td"].Number();
  return out;
}

}  // namespace terrace
