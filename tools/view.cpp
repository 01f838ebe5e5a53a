// SPDX-License-Identifier: BSD-3-Clause
#include <atomic>
#include <cstdio>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>

#include "daemon/config.h"
#include "daemon/interrupt.h"
#include "lcmtypes/open_bus.h"
#include "results/replay_result.h"
#include "tools/bus.h"
#include "tools/commands.h"
#include "tools/view_bus.h"
#include "tools/view_page.h"
#include "tools/view_recording.h"
#include "tools/view_server.h"

namespace terrace {
namespace {

struct ViewOptions {
  BusOptions bus;
  ViewServerOptions server;
  std::string log;
  std::string result;
  std::string map;
  std::string page;
  bool control = false;
};

void SayWhere(const ViewServer& server, const ViewOptions& options) {
  const std::string& address = options.server.address;
  const bool is_v6 = address.find(':') != std::string::npos;
  std::printf("view: http://%s:%d/\n", (is_v6 ? "[" + address + "]" : address).c_str(), server.port());
  std::fflush(stdout);
}

/// Serves while `work` is called again and again, until a signal ends the program or one of both fails.
template <typename Work>
void ServeWhile(ViewServer* server, Work work) {
  CatchInterrupts();
  std::atomic<bool> served = false;
  std::exception_ptr failure;
  std::thread serving([&] {
    try {
      server->Run();
    } catch (...) {
      failure = std::current_exception();
    }
    served = true;
  });
  try {
    while (!Interrupted() && !served) work();
  } catch (...) {
    failure = std::current_exception();
  }
  server->Stop();
  serving.join();
  if (failure) std::rethrow_exception(failure);
}

void ViewRecorded(const ViewOptions& options, const std::vector<ViewBytes>& records) {
  ViewFeed nothing({"", ""});
  ViewServer server(options.server, {ReadViewPage(options.page), ViewRecording(records), nullptr}, &nothing);
  SayWhere(server, options);
  ServeWhile(&server, [] { std::this_thread::sleep_for(std::chrono::milliseconds(100)); });
}

void ViewLive(const ViewOptions& options) {
  constexpr int kPatienceMs = 100;
  const Config config = ConfigOf(options.bus);
  lcm::LCM lcm(config.live.url);
  RequireOpen(lcm, config.live.url);
  ViewFeed feed({"live", config.live.url, options.control});
  ViewContent content{ReadViewPage(options.page), std::nullopt, nullptr};
  if (options.control) {
    content.command = [&](const std::string& name) { SendViewCommand(name, &lcm, config.channels.command); };
  }
  ViewServer server(options.server, std::move(content), &feed);
  ViewBus bus(&lcm, config.channels, &server);
  SayWhere(server, options);
  ServeWhile(&server, [&] {
    bus.ListenToWhatIsWanted();
    HandleFor(&lcm, kPatienceMs);
    bus.TakeMap();
  });
}

void View(const ViewOptions& options) {
  if (!options.map.empty()) return ViewRecorded(options, RecordsOfMap(options.map));
  if (!options.result.empty())
    return ViewRecorded(options, RecordsOfResult(ReadReplayResult(options.result), "result"));
  if (!options.log.empty()) return ViewRecorded(options, RecordsOfLog(options.log));
  ViewLive(options);
}

}  // namespace

void AddViewCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("view", "Show in a browser what a daemon believes, or a log, result or map");
  auto options = std::make_shared<ViewOptions>();
  AddBusOptions(command, &options->bus);
  command->add_option("--port", options->server.port, "where the browser finds it; 0: any that is free")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  command->add_option("--bind", options->server.address, "address to listen on; only this machine by default")
      ->capture_default_str();
  CLI::Option* log = command->add_option("--log", options->log, "an LCM log of what a daemon published");
  CLI::Option* result =
      command->add_option("--result", options->result, "what terraced replay wrote")->excludes(log);
  command->add_option("--map", options->map, "a terrain_map.json")->excludes(log)->excludes(result);
  command->add_flag("--control", options->control,
                    "also pass on commands: pause, resume, reset, snapshot, save");
  command->add_option("--page", options->page, "the page to serve instead of the installed one");
  command->callback([options] { View(*options); });
}

}  // namespace terrace
