// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/self_mask.h"

#include "daemon/config.h"
#include "datasets/image_file.h"

namespace terrace {

cv::Mat1b LoadSelfMask(const std::string& png, std::pair<int, int> size) {
  if (png.empty()) return {};
  GrayImage image;
  try {
    image = ReadGrayImage(png);
  } catch (const std::exception& error) {
    throw ConfigError("robot.self_mask_png = " + png + ": " + error.what());
  }
  if (std::pair(image.width, image.height) != size) {
    throw ConfigError("robot.self_mask_png = " + png + " is " + std::to_string(image.width) + "x" +
                      std::to_string(image.height) + ", the rectified images are " +
                      std::to_string(size.first) + "x" + std::to_string(size.second));
  }
  cv::Mat1b mask(image.height, image.width);
  std::copy(image.data.begin(), image.data.end(), mask.begin());
  return mask;
}

}  // namespace terrace
