// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <lcm/lcm-cpp.hpp>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/terrain_request_v1_t.hpp>

#include "client/terrain_query.h"
#include "core/terrain_request.h"
#include "daemon/request_answers.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// Takes requests from the bus, where anyone can send anything, and answers them. What that may cost is
/// bounded: in answers a frame, in bytes a second, in size and rate of one request and in their number.
/// Every function may be called from any thread. `lcm` must outlive it.
class RequestDesk {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr double kMinRate_hz = 0.1;
  static constexpr double kMaxRate_hz = 10.0;
  static constexpr double kFarthest_m = 1e5;  ///< from the world's origin
  static constexpr std::chrono::seconds kMaxDuration{60};
  static constexpr std::size_t kMaxRequests = 8;
  static constexpr int kMaxCells = 100'000;           ///< of a height map
  static constexpr double kMaxBox_m = 16.0;           ///< edge of the box of octree and map
  static constexpr std::size_t kMaxLeaves = 100'000;  ///< of an octree
  static constexpr double kMaxBytesPerSecond = 4e6;   ///< all answers together, on average

  RequestDesk(lcm::LCM* lcm, ChannelConfig channels) : lcm_(lcm), channels_(std::move(channels)) {}

  /// Publishes a reply that says whether it will be answered.
  void Take(const terrain_request_v1_t& message, Time now);
  /// Answers the request that has waited longest of those that are due and that these sources can answer.
  void Answer(const AnswerSources& sources, Time now);

 private:
  struct Standing {
    TerrainRequest request;
    Time due;
    Time end;  // after which there is no answer any more
  };

  enum class Outcome { kAnswered, kRefused, kWaits };

  static std::string ProblemOf(const TerrainRequest& request);
  void Refill(Time now);
  Outcome Answer(const TerrainRequest& request, const AnswerSources& sources);
  Outcome AnswerWithOctree(const TerrainRequest& request, const Eigen::AlignedBox3d& box_world,
                           const AnswerSources& sources);
  void Reply(std::int64_t request_id, std::int8_t result, const std::string& text);
  template <typename Message>
  void Publish(const std::string& channel, const Message& message);
  const TerrainQuery& QueryTo(const TerrainMapPtr& map);

  lcm::LCM* const lcm_;
  const ChannelConfig channels_;
  std::mutex mutex_;  // of all that follows
  std::map<std::int64_t, Standing> standing_;
  std::unique_ptr<TerrainQuery> query_;  // to the map that was asked last
  double budget_bytes_ = kMaxBytesPerSecond;
  std::optional<Time> t_budget_;
};

}  // namespace terrace
