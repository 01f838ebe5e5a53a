// SPDX-License-Identifier: BSD-3-Clause
#include "test/lossy_relay.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace terrace {
namespace {

sockaddr_in AddressOf(const std::string& group, int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, group.c_str(), &address.sin_addr);
  return address;
}

/// Hears every packet of the group on that port.
int Listen(const std::string& group, int port) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  const int yes = 1, buffer_bytes = 4 << 20;
  const sockaddr_in address = AddressOf(group, port);
  const ip_mreq membership{address.sin_addr, {htonl(INADDR_ANY)}};
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  setsockopt(fd, SOL_SOCKET, SO_REUSEPORT, &yes, sizeof(yes));
  setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof(buffer_bytes));
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0)
    throw std::runtime_error(group + ":" + std::to_string(port) + ": cannot listen there");
  const unsigned char ttl = 0;
  setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl));
  return fd;
}

/// Of a message in one packet: magic, number, channel, zero, data. Empty: it is none.
std::string ChannelOf(const char* packet, std::size_t size) {
  constexpr std::size_t kHeaderBytes = 8;
  if (size <= kHeaderBytes || std::memcmp(packet, "LC02", 4) != 0) return "";
  const char* const begin = packet + kHeaderBytes;
  return {begin, std::find(begin, packet + size, '\0')};
}

}  // namespace

LossyRelay::LossyRelay(const std::string& group, int port, int far_port, std::vector<std::string> forth,
                       std::vector<std::string> back, double loss, unsigned seed)
    : group_(group),
      port_(port),
      far_port_(far_port),
      forth_(std::move(forth)),
      back_(std::move(back)),
      loss_(loss),
      random_(seed),
      near_socket_(Listen(group, port)),
      far_socket_(Listen(group, far_port)),
      thread_([this] { Work(); }) {}

LossyRelay::~LossyRelay() {
  end_ = true;
  thread_.join();
  close(near_socket_);
  close(far_socket_);
}

void LossyRelay::Work() {
  pollfd both[2] = {{near_socket_, POLLIN, 0}, {far_socket_, POLLIN, 0}};
  while (!end_) {
    constexpr int kPatienceMs = 50;
    if (poll(both, 2, kPatienceMs) <= 0) continue;
    if (both[0].revents & POLLIN) Carry(near_socket_, far_port_, forth_);
    if (both[1].revents & POLLIN) Carry(far_socket_, port_, back_);
  }
}

void LossyRelay::Carry(int from, int to_port, const std::vector<std::string>& channels) {
  constexpr std::size_t kFragmentBytes = 1500 - 28;  // less the headers of IP and UDP
  char packet[1 << 16];
  const ssize_t received = recv(from, packet, sizeof(packet), 0);
  if (received <= 0) return;
  const auto size = static_cast<std::size_t>(received);
  // What is not named is not carried, so that nothing goes round in circles.
  if (std::find(channels.begin(), channels.end(), ChannelOf(packet, size)) == channels.end()) return;
  for (std::size_t at = 0; at < size; at += kFragmentBytes) {
    if (std::uniform_real_distribution<>(0.0, 1.0)(random_) >= loss_) continue;
    ++num_lost_;
    return;
  }
  const sockaddr_in to = AddressOf(group_, to_port);
  sendto(from, packet, size, 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  ++num_carried_;
}

}  // namespace terrace
