// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>

#include "daemon/interrupt.h"
#include "lcmtypes/default_url.h"
#include "lcmtypes/open_bus.h"
#include "tools/bus.h"
#include "tools/commands.h"
#include "tools/result_server.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;

struct ServeOptions {
  std::string result;
  std::string url = DefaultUrl();
  double seconds = 0.0;
};

void Serve(const ServeOptions& options) {
  CatchInterrupts();
  const TerrainMapPtr map = MapToServe(options.result);
  lcm::LCM lcm(options.url);
  RequireOpen(lcm, options.url);
  ResultServer server(&lcm, map);
  std::printf("serving %zu regions and %zu staircases on %s until Ctrl-C\n", map->regions.size(),
              map->staircases.size(), options.url.c_str());
  std::fflush(stdout);
  constexpr int kPatienceMs = 20;
  const Clock::time_point start = Clock::now();
  while (!Interrupted() &&
         (options.seconds == 0.0 || Clock::now() - start < std::chrono::duration<double>(options.seconds))) {
    HandleFor(&lcm, kPatienceMs);
    server.Tick(Clock::now());
  }
}

}  // namespace

void AddServeCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "serve",
      "Publish the finished map of a result as the daemon does, for a planner that is written at a desk");
  auto options = std::make_shared<ServeOptions>();
  command->add_option("RESULT", options->result, "folder that `terraced replay` wrote, or a .terrace file")
      ->required();
  command->add_option("--url", options->url, "LCM provider")->capture_default_str();
  command->add_option("--seconds", options->seconds, "end after this time; 0: at Ctrl-C")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->callback([options] { Serve(*options); });
}

}  // namespace terrace
