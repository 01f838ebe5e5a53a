// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/explanation.h"
#include "core/pose_estimate.h"
#include "core/terrain_map.h"
#include "labeling/labeling_config.h"
#include "labeling/staircase_config.h"
#include "polygonization/polygon.h"

namespace terrace {

/// Decides what a planner may read each polygon as, and finds staircases.
class TerrainLabeler {
 public:
  /// @param camera       tells whether the top of a face was in view; width 0: not known
  /// @param T_body_left  where the camera sits on the body; none: the body is taken to be at the camera
  TerrainLabeler(const LabelingConfig& config, const StaircaseConfig& staircases, const RobotConfig& robot,
                 const StereoCamera& camera, const std::optional<Eigen::Isometry3d>& T_body_left,
                 std::int64_t map_id = 1);
  ~TerrainLabeler();

  /// @param pose  where the camera is now: what is reachable is reachable from there
  TerrainMapPtr Label(const PolygonUpdate& update, const PoseEstimate& pose, const Gravity& gravity);

  /// Why regions and staircases are what they were last told to be, in words and numbers.
  /// @param only  the id of one region or staircase (either may have it); none: all
  Explanations Explain(const std::optional<std::int64_t>& only = std::nullopt) const;

  /// Sentences for the user, new with the last frame.
  const std::vector<std::string>& warnings() const;

  /// The map as last labelled; never null.
  const TerrainMapPtr& map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace terrace
