// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "labeling/labeling_config.h"
#include "labeling/staircase_config.h"
#include "mapping/mapping_config.h"
#include "polygonization/cell_modeller.h"
#include "polygonization/merging_config.h"
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
