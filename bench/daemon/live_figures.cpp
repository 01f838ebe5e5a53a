// SPDX-License-Identifier: BSD-3-Clause
// Plays a log to a live daemon and measures it from outside: how late poses and terrain are, whether a
// planner behind a lossy link is in step, what the daemon uses. live_figures.py starts it, in a network of
// its own; the last line is JSON.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "bench/daemon/bus_watch.h"
#include "client/terrain_client.h"
#include "core/statistics.h"
#include "datasets/lcm_event_log.h"
#include "lcmtypes/channels.h"
#include "test/lossy_relay.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;
constexpr char kGroup[] = "239.255.76.67";
constexpr int kPort = 7667, kFarPort = 7668;

std::string Url(int port) {
  return "udpm://" + std::string(kGroup) + ":" + std::to_string(port) + "?ttl=0&recv_buf_size=4194304";
}

std::int64_t NowUs() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

/// Processor time of a process [s].
double CpuSecondsOf(int pid) {
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string field;
  long ticks = 0;
  constexpr int kUserTime = 14, kSystemTime = 15;
  for (int i = 1; i <= kSystemTime && stat >> field; ++i)
    if (i == kUserTime || i == kSystemTime) ticks += std::atol(field.c_str());
  return static_cast<double>(ticks) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// What the log holds for a daemon, pairs behind the first IMU sample that is not older: it is there already.
std::vector<LcmEvent> EventsOf(const std::string& log) {
  const ChannelConfig channels;
  LcmEventReader reader(log);
  std::vector<LcmEvent> events;
  std::vector<LcmEvent> waiting;
  LcmEvent event;
  while (reader.Next(&event)) {
    if (event.channel == channels.images) {
      waiting.push_back(event);
      continue;
    }
    if (event.channel == channels.true_pose) continue;
    events.push_back(event);
    if (event.channel != channels.imu) continue;
    for (LcmEvent& pair : waiting) {
      pair.utime = std::max(pair.utime, event.utime);
      events.push_back(std::move(pair));
    }
    waiting.clear();
  }
  for (LcmEvent& pair : waiting) events.push_back(std::move(pair));
  return events;
}

/// @return  by how much events were late because the machine was busy with other things: how far figures can
/// be believed [ms, 99 %]
double Play(const std::vector<LcmEvent>& events, double speed) {
  std::vector<double> late_ms;
  lcm::LCM lcm(Url(kPort));
  const auto start = Clock::now();
  for (const LcmEvent& event : events) {
    const double t_us = static_cast<double>(event.utime - events.front().utime) / speed;
    std::this_thread::sleep_until(start + std::chrono::microseconds(static_cast<std::int64_t>(t_us)));
    late_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count() - 1e-3 * t_us);
    lcm.publish(event.channel, event.data.data(), static_cast<unsigned>(event.data.size()));
  }
  return Quantile(late_ms, 0.99);
}

/// A planner behind the lossy link; sees every few milliseconds whether it holds a state as new as that of
/// 0.3 s ago.
class FarPlanner {
 public:
  explicit FarPlanner(const BusWatch* watch)
      : watch_(watch), lcm_(Url(kFarPort)), client_(&lcm_), thread_([this] { Work(); }) {}
  ~FarPlanner() {
    end_ = true;
    thread_.join();
  }

  void StopCounting() { counting_ = false; }
  /// When it came to hold the state that it holds.
  std::int64_t t_held_since() const { return t_held_since_; }
  double share_in_step() const {
    return num_samples_ == 0 ? 0.0 : double(num_in_step_) / double(num_samples_);
  }
  bool Holds(const BusWatch::State& state) const {
    const TerrainMapPtr map = client_.map();
    return map && (map->map_id > state.map_id || (map->map_id == state.map_id && map->seq >= state.seq));
  }

 private:
  void Work() {
    constexpr std::int64_t kFreshUs = 300'000;
    while (!end_) {
      lcm_.handleTimeout(5);
      if (const TerrainMapPtr map = client_.map(); map && (map->map_id != map_id_ || map->seq != seq_)) {
        map_id_ = map->map_id, seq_ = map->seq;
        t_held_since_ = NowUs();
      }
      const BusWatch::State stood = watch_->StateAt(NowUs() - kFreshUs);
      if (stood.seq == 0 || !counting_) continue;
      // Messages come in bursts: each moment counts as long as it lasts.
      const auto now = Clock::now();
      const auto since = last_ ? now - *last_ : Clock::duration::zero();
      last_ = now;
      num_samples_ += since.count();
      if (Holds(stood)) num_in_step_ += since.count();
    }
  }

  const BusWatch* const watch_;
  lcm::LCM lcm_;
  TerrainClient client_;
  std::optional<Clock::time_point> last_;
  std::int64_t map_id_ = 0, seq_ = 0;  // of the thread, like what stands before
  std::atomic<std::int64_t> t_held_since_{0};
  std::atomic<std::int64_t> num_samples_{0}, num_in_step_{0};  // in ticks of the clock
  std::atomic<bool> counting_{true}, end_{false};
  std::thread thread_;
};

nlohmann::json LatenciesOf(const BusWatch& watch) {
  std::vector<double> poses_ms, terrain_ms;
  int num_frames = 0;
  for (const auto& [utime, frame] : watch.frames()) {
    if (frame.images == 0) continue;
    ++num_frames;
    if (frame.pose != 0) poses_ms.push_back(1e-3 * static_cast<double>(frame.pose - frame.images));
    if (frame.terrain != 0) terrain_ms.push_back(1e-3 * static_cast<double>(frame.terrain - frame.images));
  }
  return {{"frames", num_frames},
          {"pose_share", static_cast<double>(poses_ms.size()) / std::max(1, num_frames)},
          {"pose_p50_ms", Quantile(poses_ms, 0.5)},
          {"pose_p99_ms", Quantile(poses_ms, 0.99)},
          {"terrain_frames", terrain_ms.size()},
          {"terrain_p50_ms", Quantile(terrain_ms, 0.5)},
          {"terrain_p99_ms", Quantile(terrain_ms, 0.99)}};
}

int Measure(const std::string& log, double speed, double loss, unsigned seed, int daemon_pid) {
  const std::vector<LcmEvent> events = EventsOf(log);
  if (events.empty()) return 1;
  BusWatch watch(Url(kPort));
  const ChannelConfig channels;
  const LossyRelay relay(kGroup, kPort, kFarPort, {channels.terrain}, {channels.repair}, loss, seed);
  FarPlanner planner(&watch);
  const double cpu_s = CpuSecondsOf(daemon_pid);
  const std::int64_t start = NowUs();
  const double late_ms = Play(events, speed);
  const double duration_s = 1e-6 * static_cast<double>(NowUs() - start);
  const double used_s = CpuSecondsOf(daemon_pid) - cpu_s;
  planner.StopCounting();

  // What is under way comes to its end; then the planner must hold the last state.
  double caught_up_s = -1.0;
  const auto waiting_since = Clock::now();
  const auto Waited = [&] { return std::chrono::duration<double>(Clock::now() - waiting_since).count(); };
  while (Waited() < 10.0 && caught_up_s < 0.0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const std::vector<BusWatch::State> states = watch.states();
    if (Waited() > 0.5 && !states.empty() && planner.Holds(states.back()))
      caught_up_s =
          std::max(0.0, 1e-6 * static_cast<double>(planner.t_held_since() - states.back().t_published));
  }
  nlohmann::json figures = LatenciesOf(watch);
  constexpr std::int64_t kSettledUs = 5'000'000;
  figures["player_late_p99_ms"] = late_ms;
  figures["seconds"] = duration_s;
  figures["cpu_cores"] = used_s / duration_s;
  figures["in_step"] = planner.share_in_step();
  figures["caught_up_s"] = caught_up_s;
  figures["relay_lost"] = relay.num_lost();
  figures["relay_carried"] = relay.num_carried();
  figures["new_ids_after_5_s"] = watch.NewIdsSince(start + kSettledUs);
  figures["terrain_bytes_per_s_after_5_s"] =
      static_cast<double>(watch.TerrainBytesSince(start + kSettledUs)) / std::max(1.0, duration_s - 5.0);
  std::printf("%s\n", figures.dump().c_str());
  return 0;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "use: terrace_live_figures LOG SPEED LOSS SEED DAEMON_PID\n");
    return 2;
  }
  return terrace::Measure(argv[1], std::atof(argv[2]), std::atof(argv[3]),
                          static_cast<unsigned>(std::atoi(argv[4])), std::atoi(argv[5]));
}
