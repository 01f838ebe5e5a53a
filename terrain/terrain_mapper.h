// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "core/explanation.h"
#include "core/map_change.h"
#include "core/pose_estimate.h"
#include "core/stage_meter.h"
#include "labeling/gravity_from_planes.h"
#include "labeling/terrain_labeler.h"
#include "mapping/terrain_octree.h"
#include "odometry/visual_odometry.h"
#include "polygonization/cell_modeller.h"
#include "polygonization/polygon_merger.h"
#include "stereo/disparity_image.h"
#include "terrain/resting_view.h"
#include "terrain/terrain_config.h"

namespace terrace {

/// What one pair of images shows.
struct DepthView {
  const DisparityImage& disparity;
  const StereoCamera& camera;  ///< that it belongs to
  const cv::Mat1b& self_mask;  ///< of the image's size, 0 where the robot sees itself; empty: nowhere
};

/// The one owner of the map: octree, planes in cells, polygons and labels. Near the robot, within
/// `mapping.window_m`, it keeps the evidence from which they can change; beyond, regions stay as they are,
/// and farther away than `mapping.keep_beyond_m` they are forgotten.
///
/// What always holds: the parts have seen the same frames of the same map, and map() is what the last of them
/// led to.
class TerrainMapper {
 public:
  /// @param camera       tells whether the top of a face was in view
  /// @param T_body_left  where the camera sits on the body; none: the body is taken to be at the camera
  /// @param meters       measures the stages; must outlive the mapper
  TerrainMapper(const TerrainConfig& config, const StereoCamera& camera,
                const std::optional<Eigen::Isometry3d>& T_body_left, StageMeters* meters);

  /// Adds what one frame shows. The pose must be one that may be mapped.
  MapChange Update(const DepthView& view, const PoseEstimate& pose, const Gravity& gravity);
  /// A frame that showed nothing that may be mapped.
  MapChange Unchanged() const;
  /// Begins a new map with the next `map_id`. Nothing of the old one is left.
  void Reset();

  /// As the last frame left it; never null.
  const TerrainMapPtr& map() const { return parts_->labeler.map(); }
  /// Why regions and staircases are what map() says, in words and numbers.
  /// @param only  the id of one region or staircase (either may have it); none: all
  Explanations Explain(const std::optional<std::int64_t>& only = std::nullopt) const {
    return parts_->labeler.Explain(only);
  }
  /// As the last frame left it; the next Update() changes it.
  const TerrainOctree& octree() const { return parts_->octree; }
  /// Sentences for the user, new with the last frame that was added.
  const std::vector<std::string>& warnings() const { return parts_->labeler.warnings(); }
  /// What the last frame showed of the direction of gravity; none when it showed no level ground.
  const std::optional<GravityHint>& gravity_hint() const { return gravity_hint_; }

 private:
  /// Everything that belongs to one map, so that a new map can have none of it.
  struct Parts {
    Parts(const TerrainConfig& config, const StereoCamera& camera,
          const std::optional<Eigen::Isometry3d>& T_body_left, double window_m, std::int64_t map_id);

    RestingView resting;
    TerrainOctree octree;
    CellModeller modeller;
    PolygonMerger merger;
    TerrainLabeler labeler;
    LevelPlanes level_planes;
  };

  /// The polygons after what a frame shows is added to them.
  PolygonUpdate AddEvidence(const DepthView& view, const PoseEstimate& pose);

  /// Beyond the window evidence is forgotten, and regions stay.
  void FoldFarFrom(const Eigen::Vector3d& p_world);
  void CountCells(MapChange* change) const;

  const TerrainConfig config_;
  const StereoCamera camera_;
  const std::optional<Eigen::Isometry3d> T_body_left_;
  const double window_m_;
  StageMeters* const meters_;
  std::optional<Parts> parts_;  // always there
  std::optional<GravityHint> gravity_hint_;
};

}  // namespace terrace
