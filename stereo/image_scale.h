// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/camera.h"
#include "core/sensor_frame.h"

namespace terrace {

/// The size at which images are worked on. YAML section: `camera`.
struct ImageScaleConfig {
  /// 0.5 or 0.25: raw images are halved once or twice when they come in, for cameras with more pixels than
  /// there is time for. `camera.json`, disparities, masks and all settings in pixels then describe the halved
  /// images. 1: as they are.
  double scale = 1.0;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// The calibration of the images after halving; lens models count in focal lengths, so that they stay.
StereoCalibration Scaled(StereoCalibration calibration, const ImageScaleConfig& config);
/// Means of two by two pixels; those of a last odd row or column of one by two. The rest stays as it is.
StereoPair Scaled(StereoPair pair, const ImageScaleConfig& config);

}  // namespace terrace
