// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace terrace {

/// A lossy link between two LCM buses of one computer: carries the packets of some channels from one
/// multicast port to another and loses them as a network with an MTU of 1,500 bytes does, each fragment with
/// the same probability, a packet with any of its fragments. Only messages of one LCM packet (below 64 kB)
/// are carried. Works in a thread of its own.
class LossyRelay {
 public:
  /// @param forth, back  channels that are carried from `port` to `far_port`, and the other way; none in both
  /// Throws std::runtime_error when a socket cannot be had.
  LossyRelay(const std::string& group, int port, int far_port, std::vector<std::string> forth,
             std::vector<std::string> back, double loss, unsigned seed);
  ~LossyRelay();
  LossyRelay(const LossyRelay&) = delete;
  LossyRelay& operator=(const LossyRelay&) = delete;

  std::int64_t num_lost() const { return num_lost_; }
  std::int64_t num_carried() const { return num_carried_; }

 private:
  void Work();
  void Carry(int from, int to_port, const std::vector<std::string>& channels);

  const std::string group_;
  const int port_, far_port_;
  const std::vector<std::string> forth_, back_;
  const double loss_;
  std::mt19937 random_;
  int near_socket_ = -1, far_socket_ = -1;
  std::atomic<std::int64_t> num_lost_{0}, num_carried_{0};
  std::atomic<bool> end_{false};
  std::thread thread_;
};

}  // namespace terrace
