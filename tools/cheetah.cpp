// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>

#include "client/terrain_client.h"
#include "daemon/interrupt.h"
#include "lcmtypes/open_bus.h"
#include "tools/bus.h"
#include "tools/cheetah_peer.h"
#include "tools/commands.h"

namespace terrace {
namespace {

struct CheetahOptions {
  BusOptions bus;
  std::string walker_url;
  double rate_hz = 10.0;
  double seconds = 0.0;
  FootSpec foot;
};

void ServeTheCheetah(const CheetahOptions& options) {
  using PeerClock = std::chrono::steady_clock;
  const Config config = ConfigOf(options.bus);
  CatchInterrupts();
  lcm::LCM daemon(config.live.url);
  RequireOpen(daemon, config.live.url);
  const std::string url = options.walker_url.empty() ? config.live.url : options.walker_url;
  lcm::LCM walker(url);
  RequireOpen(walker, url);
  const TerrainClient client(&daemon, config.channels);
  CheetahPeer peer(&client, &walker, options.foot, options.rate_hz);
  std::printf("local_heightmap, traversability and global_to_robot on %s until Ctrl-C\n", url.c_str());
  std::string said;
  constexpr int kPatienceMs = 10;
  const PeerClock::time_point start = PeerClock::now();
  while (!Interrupted() && (options.seconds == 0.0 ||
                            PeerClock::now() - start < std::chrono::duration<double>(options.seconds))) {
    HandleFor(&daemon, kPatienceMs);
    peer.Tick(PeerClock::now());
    if (peer.problem() == said) continue;
    said = peer.problem();
    std::printf("%s\n",
                said.empty() ? "the walker hears of the ground" : ("nothing is known: " + said).c_str());
    std::fflush(stdout);
  }
}

}  // namespace

void AddCheetahCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "cheetah",
      "Tell MIT's Cheetah-Software, unchanged, of the ground: its vision gait's channels from a daemon");
  auto options = std::make_shared<CheetahOptions>();
  AddBusOptions(command, &options->bus);
  command->add_option("--to", options->walker_url,
                      "LCM provider that the walker listens on; default: the daemon's");
  command->add_option("--rate", options->rate_hz, "of heights and traversability, in Hz")
      ->check(CLI::Range(0.5, 50.0))
      ->capture_default_str();
  command->add_option("--foot-radius", options->foot.radius_m, "of the sole, in metres")
      ->check(CLI::Range(0.0, 0.2))
      ->capture_default_str();
  command->add_option("--clear-drop", options->foot.clear_drop_m, "from the sole to a drop, in metres")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  command->add_option("--seconds", options->seconds, "end after this time; 0: at Ctrl-C")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->callback([options] { ServeTheCheetah(*options); });
}

}  // namespace terrace
