// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "labeling/staircase_finder.h"
#include "labeling/terrain_labeler.h"
#include "mapping/terrain_octree.h"
#include "odometry/visual_odometry.h"
#include "polygonization/cell_modeller.h"
#include "polygonization/polygon_merger.h"
#include "stereo/cloud.h"
#include "stereo/disparity_matcher.h"

namespace terrace {

/// How the stages work together. YAML section: `pipeline`.
struct FlowConfig {
  /// What a later stage learns from a frame reaches the earlier stages this many frames later, in every mode,
  /// so that the map does not depend on the number of threads.
  int feedback_lag_frames = 2;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

/// The settings of every stage.
struct PipelineConfig {
  FlowConfig flow;
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
