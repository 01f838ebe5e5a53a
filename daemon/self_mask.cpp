// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/self_mask.h"

#include "daemon/config.h"
#include "datasets/image_file.h"

namespace terrace {

cv::Mat1b LoadSelfMask(const std::string& png, const StereoCalibration& calibration) {
  if (png.empty()) return {};
  GrayImage image;
  try {
    image = ReadGrayImage(png);
  } catch (const std::exception& error) {
    throw ConfigError("robot.self_mask_png = " + png + ": " + error.what());
  }
  if (image.width != calibration.width || image.height != calibration.height) {
    throw ConfigError("robot.self_mask_png = " + png + " is " + std::to_string(image.width) + "x" +
                      std::to_string(image.height) + ", the camera's images are " +
                      std::to_string(calibration.width) + "x" + std::to_string(calibration.height));
  }
  cv::Mat1b mask(image.height, image.width);
  std::copy(image.data.begin(), image.data.end(), mask.begin());
  return mask;
}

}  // namespace terrace
