// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <lcm/lcm-cpp.hpp>

namespace terrace {

/// When what arrived on a bus, by the kernel's clock of packets [us since the epoch]. Listens in a thread of
/// its own.
class BusWatch {
 public:
  struct Frame {
    std::int64_t images = 0;   ///< the last packet of the pair
    std::int64_t pose = 0;     ///< 0: none came
    std::int64_t terrain = 0;  ///< the last part of the delta that it led to; 0: it led to none
  };
  struct State {
    std::int64_t t_published = 0;
    std::int64_t map_id = 0;
    std::int64_t seq = 0;
  };

  explicit BusWatch(const std::string& url);
  ~BusWatch();

  /// By the utime of the images.
  std::map<std::int64_t, Frame> frames() const;
  /// The states of the map, in the order in which they were published.
  std::vector<State> states() const;
  /// Newest state published at that time or before; seq 0: none.
  State StateAt(std::int64_t t) const;
  /// Bytes on the terrain's channel, and region ids never heard before, from then on.
  std::int64_t TerrainBytesSince(std::int64_t t) const;
  int NewIdsSince(std::int64_t t) const;

 private:
  void OnImages(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnPose(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void OnTerrain(const lcm::ReceiveBuffer* buffer, const std::string& channel);

  lcm::LCM lcm_;
  mutable std::mutex mutex_;
  std::map<std::int64_t, Frame> frames_;
  std::vector<State> states_;
  std::vector<std::pair<std::int64_t, std::int64_t>> terrain_bytes_;  // when, how many
  std::map<std::int64_t, std::int64_t> ids_;                          // region, when it was heard first
  std::atomic<bool> end_{false};
  std::thread thread_;
};

}  // namespace terrace
