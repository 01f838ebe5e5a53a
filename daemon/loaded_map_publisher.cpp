// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/loaded_map_publisher.h"

#include <utility>

#include "lcmtypes/map_transform_codec.h"

namespace terrace {

LoadedMapPublisher::LoadedMapPublisher(lcm::LCM* lcm, const ChannelConfig& channels, double snapshot_period_s)
    : lcm_(lcm), channels_(channels), snapshot_period_s_(snapshot_period_s) {
  channels_.terrain = channels.loaded_map;
}

void LoadedMapPublisher::Tick(const LoadedMap& loaded, std::int64_t terrain_map_id) {
  const TerrainMapPtr alone = loaded.unplaced();
  if (std::exchange(alone_, alone) != alone) {
    publisher_.reset();
    if (alone) {
      publisher_.emplace(lcm_, channels_, alone->T_body_left, snapshot_period_s_);
      MapChange whole;
      whole.map = alone;
      publisher_->PublishTerrain(whole);
    }
    due_ = {};
  }
  if (publisher_) publisher_->Tick();
  if (std::chrono::steady_clock::now() < due_ && terrain_map_id == said_of_map_id_) return;
  SayWhereItLies(loaded, terrain_map_id);
}

bool LoadedMapPublisher::Answer(const terrain_repair_v1_t& repair) {
  if (!publisher_ || repair.map_id != publisher_->map_id()) return false;
  publisher_->Answer(repair);
  return true;
}

void LoadedMapPublisher::SayWhereItLies(const LoadedMap& loaded, std::int64_t terrain_map_id) {
  due_ = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  said_of_map_id_ = terrain_map_id;
  std::optional<MapTransform> transform = loaded.transform();
  if (!transform) return;
  transform->map_id = transform->placing == MapPlacing::kNotFound ? 0 : terrain_map_id;
  const map_transform_v1_t message = ToMessage(*transform);
  lcm_->publish(channels_.map_transform, &message);
}

}  // namespace terrace
