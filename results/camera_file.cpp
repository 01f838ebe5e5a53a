// SPDX-License-Identifier: BSD-3-Clause
#include "results/camera_file.h"

#include <vector>

#include "results/json_text.h"

namespace terrace {

std::string CameraJson(const ResultCamera& result) {
  const StereoCamera& camera = result.camera;
  const OrderedJson json = {{"width", camera.width},
                            {"height", camera.height},
                            {"fx", camera.fx},
                            {"fy", camera.fy},
                            {"cx", camera.cx},
                            {"cy", camera.cy},
                            {"baseline_m", camera.baseline_m},
                            {"R_rect_raw", RowMajorJson(result.R_rect_raw)},
                            {"T_body_left", result.T_body_left ? RowMajorJson(result.T_body_left->matrix())
                                                               : OrderedJson(nullptr)}};
  return Dumped(json, 1) + "\n";
}

ResultCamera ReadCameraFile(const std::filesystem::path& path) {
  const nlohmann::json document = ReadJsonFile(path);
  const JsonValue json(document, path.string());
  ResultCamera result;
  result.camera.width = static_cast<int>(json["width"].Integer());
  result.camera.height = static_cast<int>(json["height"].Integer());
  result.camera.fx = json["fx"].Number();
  result.camera.fy = json["fy"].Number();
  result.camera.cx = json["cx"].Number();
  result.camera.cy = json["cy"].Number();
  result.camera.baseline_m = json["baseline_m"].Number();
  const std::vector<double> rotation = json["R_rect_raw"].Numbers(9);
  result.R_rect_raw = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  if (!json["T_body_left"].IsNull()) {
    const std::vector<double> rows = json["T_body_left"].Numbers(16);
    result.T_body_left =
        Eigen::Isometry3d(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(rows.data()));
  }
  return result;
}

}  // namespace terrace
