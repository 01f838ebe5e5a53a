// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include <lcm/lcm-cpp.hpp>
#include <terrace/command_reply_v1_t.hpp>

#include "core/terrain_request.h"
#include "tools/view_feed.h"

namespace terrace {

/// Asks a daemon for what browsers want and it does not send by itself, as long as they want it. Each request
/// stands for a few seconds and is made again in time: a program that has gone costs the daemon nothing, and
/// a daemon that comes back is asked.
class ViewRequests {
 public:
  /// @param lcm  must outlive this
  ViewRequests(lcm::LCM* lcm, std::string channel);

  /// To be called at least once a second.
  void Ask(const ViewSlots& wanted);
  /// Whether a reply only says that a request of this program will be answered, or will be made again for
  /// less.
  bool TakeReply(const command_reply_v1_t& reply);

 private:
  using Time = std::chrono::steady_clock::time_point;

  struct Standing {
    TerrainRequest request;
    std::optional<Time> t_asked;  // none: it does not stand
  };

  void Ask(bool wanted, Standing* standing);
  void Publish(const TerrainRequest& request);

  lcm::LCM* const lcm_;
  const std::string channel_;
  Standing cells_;
  Standing disparity_;
};

}  // namespace terrace
