// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>

#include "daemon/interrupt.h"
#include "lcmtypes/open_bus.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/subscribe.h"
#include "tools/bus.h"
#include "tools/commands.h"
#include "tools/health.h"

namespace terrace {
namespace {

struct StatusOptions {
  BusOptions bus;
  bool json = false;
  bool watch = false;
  double wait_s = 3.0;
};

/// Waits for what a daemon says about itself.
class StatusListener {
 public:
  StatusListener(lcm::LCM* lcm, const std::string& channel) : lcm_(lcm) {
    Subscribe<&StatusListener::OnStatus>(lcm_, channel, this);
  }

  /// None: nothing came in time, or Ctrl-C did.
  std::optional<Status> Next(std::chrono::duration<double> patience) {
    constexpr int kStepMs = 50;
    const auto end = std::chrono::steady_clock::now() + patience;
    while (!newest_ && !Interrupted() && std::chrono::steady_clock::now() < end) HandleFor(lcm_, kStepMs);
    return std::exchange(newest_, std::nullopt);
  }

 private:
  void OnStatus(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto message = SafeDecode<status_v1_t>(buffer->data, buffer->data_size);
    if (!message) return;
    if (const auto status = FromMessage(*message)) newest_ = status;
  }

  lcm::LCM* const lcm_;
  std::optional<Status> newest_;
};

void Say(const Status& status, const std::vector<Finding>& findings, bool as_json) {
  const std::string text = as_json ? StatusJson(status, findings) + "\n" : StatusPage(status, findings);
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void ShowStatus(const StatusOptions& options) {
  const Config config = ConfigOf(options.bus);
  CatchInterrupts();
  lcm::LCM lcm(config.live.url);
  RequireOpen(lcm, config.live.url);
  StatusListener listener(&lcm, config.channels.status);
  const std::chrono::duration<double> patience(options.wait_s);
  std::optional<Status> before;
  bool healthy = false;
  for (;;) {
    const std::optional<Status> status = listener.Next(patience);
    if (Interrupted() && !status) break;
    if (!status) {
      const std::string text = "nothing on " + config.channels.status + " for " +
                               std::to_string(options.wait_s) +
                               " s: no daemon runs, or the network does not carry it; see terrace doctor";
      if (!options.watch) throw std::runtime_error(text);
      std::fprintf(stderr, "%s\n", text.c_str());
      healthy = false;
      continue;
    }
    // Counts of a daemon that has begun anew begin anew, too.
    const bool same_daemon = before && status->uptime_ms >= before->uptime_ms;
    const std::vector<Finding> findings = JudgeStatus(*status, same_daemon ? &*before : nullptr);
    Say(*status, findings, options.json);
    healthy = !AnyTrouble(findings);
    before = status;
    if (!options.watch) break;
  }
  if (!healthy) throw std::runtime_error("the daemon is not healthy");
}

}  // namespace

void AddStatusCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("status", "Say how a daemon is; exit code 0 when it is healthy, else 1");
  auto options = std::make_shared<StatusOptions>();
  AddBusOptions(command, &options->bus);
  command->add_flag("--json", options->json, "one line of JSON instead");
  command->add_flag("--watch", options->watch,
                    "again and again, until Ctrl-C; counts are then those of each second");
  command->add_option("--wait", options->wait_s, "for a status, in seconds")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command->callback([options] { ShowStatus(*options); });
}

}  // namespace terrace
