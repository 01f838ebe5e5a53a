// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <lcm/lcm-cpp.hpp>

#include "client/query_types.h"
#include "client/terrain_client.h"
#include "client/terrain_query.h"
#include "tools/cheetah_maps.h"

namespace terrace {

/// Stands between a daemon and MIT's Cheetah-Software: the map and the pose that the one publishes, as
/// `local_heightmap`, `traversability` and `global_to_robot`, which the other listens to.
class CheetahPeer {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// @param client  of the daemon; both must outlive the peer
  CheetahPeer(const TerrainClient* client, lcm::LCM* walker, FootSpec foot, double rate_hz)
      : client_(client), walker_(walker), foot_(foot), period_(1.0 / rate_hz) {}

  /// Sends every new pose, and the ground when it is due. To be called every 20 ms or so.
  void Tick(Time now);
  /// Why the walker is told that nothing is known; empty: it is not.
  const std::string& problem() const { return problem_; }

 private:
  std::string ProblemOf(const std::optional<BodyPose>& pose) const;
  void SendGround(const CheetahMaps& maps);
  const TerrainQuery& QueryTo(const TerrainMapPtr& map);

  const TerrainClient* const client_;
  lcm::LCM* const walker_;
  const FootSpec foot_;
  const std::chrono::duration<double> period_;
  std::unique_ptr<TerrainQuery> query_;
  std::optional<double> ground_z_world_;                  // under the robot, when it was first known
  int epoch_ = 0;                                         // for which it holds
  std::optional<Timestamp> t_pose_;                       // of the last pose that was sent
  Eigen::Vector3d body_world_ = Eigen::Vector3d::Zero();  // in it
  std::optional<Time> t_ground_;
  std::string problem_;
};

}  // namespace terrace
