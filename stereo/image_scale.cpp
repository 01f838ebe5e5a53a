// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/image_scale.h"

#include <utility>

#include <opencv2/core/mat.hpp>

#include "core/field_problems.h"
#include "stereo/half_resolution.h"

namespace terrace {
namespace {

int NumHalvings(const ImageScaleConfig& config) {
  int num = 0;
  for (double scale = 1.0; scale > config.scale; scale *= 0.5) ++num;
  return num;
}

/// Pixel centres lie at whole numbers: the first two pixels, at 0 and 1, become the one at 0.
double HalvedCentre(double px) { return 0.5 * (px + 0.5) - 0.5; }

void Halve(RawCamera& camera) {
  camera.fx *= 0.5;
  camera.fy *= 0.5;
  camera.cx = HalvedCentre(camera.cx);
  camera.cy = HalvedCentre(camera.cy);
}

void Halve(GrayImage& image) {
  if (image.data.empty()) return;
  const cv::Mat1b whole(image.height, image.width, image.data.data());
  cv::Mat1b half;
  HalveImage(whole, half);
  image.width = half.cols;
  image.height = half.rows;
  image.data.assign(half.begin(), half.end());
}

}  // namespace

std::vector<std::string> ImageScaleConfig::Problems() const {
  FieldProblems problems;
  problems.Require(scale == 1.0 || scale == 0.5 || scale == 0.25, "scale", scale, "be 1, 0.5 or 0.25");
  return problems.Take();
}

StereoCalibration Scaled(StereoCalibration calibration, const ImageScaleConfig& config) {
  for (int i = NumHalvings(config); i > 0; --i) {
    calibration.width = (calibration.width + 1) / 2;
    calibration.height = (calibration.height + 1) / 2;
    Halve(calibration.left);
    Halve(calibration.right);
  }
  return calibration;
}

StereoPair Scaled(StereoPair pair, const ImageScaleConfig& config) {
  for (int i = NumHalvings(config); i > 0; --i) {
    Halve(pair.left);
    Halve(pair.right);
  }
  return pair;
}

}  // namespace terrace
