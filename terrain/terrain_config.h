// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "labeling/staircase_finder.h"
#include "labeling/terrain_labeler.h"
#include "mapping/mapping_config.h"
#include "polygonization/cell_modeller.h"
#include "polygonization/polygon_merger.h"
#include "stereo/cloud.h"

namespace terrace {

/// The settings of everything that makes the map.
struct TerrainConfig {
  CloudConfig cloud;
  MappingConfig mapping;
  ModellingConfig modelling;
  MergingConfig merging;
  LabelingConfig labeling;
  StaircaseConfig staircases;
  RobotConfig robot;
};

}  // namespace terrace
