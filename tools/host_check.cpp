// SPDX-License-Identifier: BSD-3-Clause
#include "tools/host_check.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/timex.h>
#include <unistd.h>

#include "core/print.h"

namespace terrace {
namespace {

// Two images of 640x480 as they are, three pairs of them.
constexpr std::int64_t kEnoughBufferBytes = 2 * 1024 * 1024;
// The daemon on a long walk, and what the camera's driver needs beside it.
constexpr std::int64_t kEnoughMemoryBytes = 512LL * 1024 * 1024;

std::string FirstLine(const char* path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

/// The number behind `key=` in the address; 0 when it is not there.
std::int64_t NumberInUrl(const std::string& url, const std::string& key) {
  const std::size_t at = url.find(key + "=");
  return at == std::string::npos ? 0 : std::atoll(url.c_str() + at + key.size() + 1);
}

/// Whether the kernel knows a way to the multicast group of the address; asks it, sends nothing.
bool HasRoute(const std::string& url) {
  std::string host = url.substr(url.find("://") + 3);
  host = host.substr(0, host.find_first_of(":/?"));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(7667);
  if (inet_pton(AF_INET, host.empty() ? "239.255.76.67" : host.c_str(), &address.sin_addr) != 1) return false;
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0) return false;
  const bool found = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  close(fd);
  return found;
}

std::int64_t AvailableMemory() {
  std::ifstream in("/proc/meminfo");
  std::string line;
  while (std::getline(in, line)) {
    constexpr char kKey[] = "MemAvailable:";
    if (line.rfind(kKey, 0) == 0) return std::atoll(line.c_str() + sizeof(kKey) - 1) * 1024;
  }
  return 0;
}

bool ClockIsSet() {
  timex state{};
  return adjtimex(&state) != -1 && (state.status & STA_UNSYNC) == 0;
}

Finding JudgeFact(bool good, Severity otherwise, const char* code, std::string text, const char* remedy) {
  return {good ? Severity::kGood : otherwise, code, std::move(text),
          good ? std::string() : std::string(remedy)};
}

double Megabytes(std::int64_t bytes) { return 1e-6 * static_cast<double>(bytes); }

void JudgeNetwork(const HostFacts& facts, std::vector<Finding>* findings) {
  if (!facts.is_multicast) return;
  findings->push_back(
      JudgeFact(facts.recv_buffer_bytes >= kEnoughBufferBytes, Severity::kTrouble, "recv_buffer_asked",
                Printed("lcm.url asks for a receive buffer of %.1f MB", Megabytes(facts.recv_buffer_bytes)),
                "lcm.url: udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152"));
  findings->push_back(
      JudgeFact(facts.rmem_max_bytes >= facts.recv_buffer_bytes && facts.rmem_max_bytes >= kEnoughBufferBytes,
                Severity::kTrouble, "rmem_max",
                Printed("net.core.rmem_max is %.1f MB", Megabytes(facts.rmem_max_bytes)),
                "sysctl -w net.core.rmem_max=2097152 now, 60-terrace-lcm.conf in /etc/sysctl.d for good"));
  findings->push_back(
      JudgeFact(facts.has_route, Severity::kTrouble, "multicast_route",
                facts.has_route ? "there is a route for multicast" : "there is no route for multicast",
                "ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo; for good: systemctl enable "
                "--now terrace-loopback"));
  findings->push_back(
      JudgeFact(facts.ttl == 0, Severity::kNote, "ttl",
                facts.ttl == 0 ? "messages stay on this computer (ttl=0)"
                               : Printed("messages go out into the network (ttl=%d), images too", facts.ttl),
                "ttl=0 unless a planner runs on another computer; then send images over a bus of their own"));
}

}  // namespace

HostFacts ReadHostFacts(const std::string& url) {
  HostFacts facts;
  facts.rmem_max_bytes = std::atoll(FirstLine("/proc/sys/net/core/rmem_max").c_str());
  facts.recv_buffer_bytes = NumberInUrl(url, "recv_buf_size");
  facts.is_multicast = url.rfind("udpm://", 0) == 0;
  facts.ttl = static_cast<int>(NumberInUrl(url, "ttl"));
  facts.has_route = facts.is_multicast && HasRoute(url);
  facts.available_memory_bytes = AvailableMemory();
  facts.num_cores = static_cast<int>(std::thread::hardware_concurrency());
  facts.load = std::atof(FirstLine("/proc/loadavg").c_str());
  facts.governor = FirstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  facts.clock_is_set = ClockIsSet();
  return facts;
}

std::vector<Finding> JudgeHost(const HostFacts& facts) {
  std::vector<Finding> findings;
  JudgeNetwork(facts, &findings);
  findings.push_back(JudgeFact(facts.available_memory_bytes >= kEnoughMemoryBytes, Severity::kTrouble,
                               "memory",
                               Printed("%.0f MB of memory are free", Megabytes(facts.available_memory_bytes)),
                               "end other programs; mapping.window_m smaller"));
  findings.push_back(JudgeFact(facts.num_cores >= 2, Severity::kNote, "cores",
                               Printed("%d cores", facts.num_cores),
                               "with one core the map takes fewer frames"));
  findings.push_back(
      JudgeFact(facts.load <= facts.num_cores, Severity::kNote, "load",
                Printed("%.1f processes want to run", facts.load),
                "other programs take the processor: Nice= and CPUAffinity= of terraced.service"));
  if (!facts.governor.empty()) {
    findings.push_back(JudgeFact(facts.governor != "powersave", Severity::kNote, "governor",
                                 "the processor's governor is " + facts.governor,
                                 "cpupower frequency-set -g performance: powersave makes poses late"));
  }
  findings.push_back(
      JudgeFact(facts.clock_is_set, Severity::kNote, "clock",
                facts.clock_is_set ? "the clock is synchronised" : "nothing keeps the clock",
                "chrony or systemd-timesyncd; needed only where stamps come from another computer"));
  return findings;
}

}  // namespace terrace
