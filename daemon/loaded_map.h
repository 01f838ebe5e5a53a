// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "client/terrace_file.h"
#include "core/camera.h"
#include "core/explanation.h"
#include "core/map_change.h"
#include "core/map_transform.h"
#include "core/pose_estimate.h"
#include "core/terrain_map.h"
#include "daemon/loaded_regions.h"
#include "daemon/loaded_staircases.h"
#include "daemon/map_placing.h"
#include "daemon/place_finder.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// A map from a file beside the one that is being made. Where it is known how it lies in the world, both are
/// one map: what was loaded keeps its ids, until what is seen takes its place. Where it is not known, the map
/// that is made goes on alone, and the loaded one stands by itself.
class LoadedMap {
 public:
  /// @param T_body_left  none: body is taken as the camera with x forward, y left, z up
  LoadedMap(const StereoCamera& camera, const std::optional<Eigen::Isometry3d>& T_body_left);

  /// Replaces what was loaded before. With the next pose that may be mapped it lies in the world, when
  /// somebody says where; else once the camera has been recognised in it. From any thread.
  void Load(SavedMap saved, std::string file, const std::optional<BodyInMap>& body);

  /// Where it lies, `map_id` aside; none: nothing is loaded. From any thread.
  std::optional<MapTransform> transform() const;
  /// The loaded map while it is not known where it lies; null: there is none such. From any thread.
  TerrainMapPtr unplaced() const;
  /// As the mapper has it, of a region or staircase of the joint map; none: it was loaded, or there is none.
  /// From any thread.
  std::optional<std::int64_t> OwnId(std::int64_t id) const;

  /// What explains regions and staircases of the mapper, under the ids of the joint map.
  Explanations InJointIds(Explanations own) const;

  /// What a frame did to the map that is made, as what it did to the joint one. In the thread of the map.
  /// @param frame  null when its images could not be used
  MapChange Join(const MapChange& own, const PoseEstimate& pose, const StereoFrame* frame);

  /// The views that were saved with it, where they lie in the world; none while that is not known. From any
  /// thread.
  std::vector<PlaceView> ViewsInWorld() const;

 private:
  /// A region of the joint map and what it was made from.
  struct Copy {
    std::shared_ptr<const TerrainRegion> source;
    std::optional<JoinedStaircases::Place> place;
    int more_revisions = 0;
    std::shared_ptr<const TerrainRegion> region;
  };
  struct InWorld {
    LoadedRegions regions;
    std::vector<Staircase> staircases;
    MapPlace place;
    std::int64_t add_to_own_ids = 0;
    std::map<std::int64_t, Copy> copies;  // by id
  };

  void FollowTheWorld(const TerrainMap& own);
  void LookForThePlace(const TerrainMap& own, const PoseEstimate& pose, const StereoFrame& frame);
  void PutIntoWorld(const MapPlace& place, const TerrainMap& own, const PoseEstimate& pose,
                    const std::string& how);
  void TakeOutOfTheWorld();
  void PutAt(const MapPlace& place, const TerrainMap& own, Timestamp t);
  void CompareWithWhatIsSeen(const TerrainMap& own, const PoseEstimate& pose);
  /// Of the own map; null: all of it.
  void TakeAwayWhatIsSeen(const TerrainMap& own, const MapDifference* changed);
  TerrainMapPtr Joint(const TerrainMap& own);
  std::vector<Staircase> OwnStaircases(const TerrainMap& own) const;
  static Copy CopyOf(const std::shared_ptr<const TerrainRegion>& source, std::int64_t add_to_id,
                     const JoinedStaircases& joined, const std::map<std::int64_t, Copy>& before);

  const Eigen::Isometry3d T_body_left_;
  mutable std::mutex mutex_;  // of everything below
  TerrainMapPtr loaded_;
  PlaceFinder finder_;
  std::string file_;
  std::optional<BodyInMap> body_;  // where it is to be put with the next pose
  std::string reason_;             // why it does not lie in the world, or is not confirmed
  MapPlace prior_;                 // of the next comparison with what is seen
  bool recognised_ = false;        // it lies where its views say, and nobody else
  bool confirmed_ = false;         // by the last one
  int num_frames_ = 0;             // that changed the own map since then
  Timestamp t_;                    // newest image
  std::optional<InWorld> in_world_;
  std::int64_t more_map_ids_ = 0;  // maps that began because one was loaded or taken out
  std::int64_t more_seqs_ = 0;     // states of the joint map beyond those of the own one
  TerrainMapPtr own_;              // of the last frame
  TerrainMapPtr joint_;            // that it led to; null: it was given out as it is
};

}  // namespace terrace
