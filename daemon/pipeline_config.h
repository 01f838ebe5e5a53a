// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/flow_config.h"
#include "daemon/self_mask_config.h"
#include "odometry/mounting.h"
#include "odometry/odometry_config.h"
#include "stereo/disparity_matcher.h"
#include "stereo/image_scale.h"
#include "stereo/rectifier.h"
#include "terrain/terrain_config.h"

namespace terrace {

/// The settings of every stage.
struct PipelineConfig {
  FlowConfig flow;
  ImageScaleConfig image_scale;
  MountingConfig mounting;
  RectifierConfig rectifier;
  DisparityConfig stereo;
  OdometryConfig odometry;
  TerrainConfig terrain;
  SelfMaskConfig self_mask;
};

}  // namespace terrace
