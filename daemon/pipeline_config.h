// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/flow_config.h"
#include "labeling/staircase_finder.h"
#include "labeling/terrain_labeler.h"
#include "mapping/terrain_octree.h"
#include "odometry/visual_odometry.h"
#include "polygonization/cell_modeller.h"
#include "polygonization/polygon_merger.h"
#include "stereo/cloud.h"
#include "stereo/disparity_matcher.h"
#include "stereo/rectifier.h"

namespace terrace {

/// The settings of every stage.
struct PipelineConfig {
  FlowConfig flow;
  RectifierConfig rectifier;
  DisparityConfig stereo;
  OdometryConfig odometry;
  CloudConfig cloud;
  MappingConfig mapping;
  ModellingConfig modelling;
  MergingConfig merging;
  LabelingConfig labeling;
  StaircaseConfig staircases;
  RobotConfig robot;
};

}  // namespace terrace
