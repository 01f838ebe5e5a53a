// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>
#include <terrace/command_reply_v1_t.hpp>

#include "client/terrain_client.h"
#include "daemon/interrupt.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/default_url.h"
#include "lcmtypes/open_bus.h"
#include "lcmtypes/pose_codec.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/status_codec.h"
#include "lcmtypes/subscribe.h"
#include "tools/bus.h"
#include "tools/commands.h"
#include "tools/terrain_words.h"

namespace terrace {
namespace {

using Clock = std::chrono::steady_clock;

struct ListenOptions {
  std::string url = DefaultUrl();
  double seconds = 0.0;
};

/// Prints what the daemon publishes, a line an event.
class Listener {
 public:
  explicit Listener(lcm::LCM* lcm) : lcm_(lcm), terrain_(lcm) {
    const ChannelConfig channels;
    Subscribe<&Listener::OnPose>(lcm_, channels.pose, this);
    Subscribe<&Listener::OnStatus>(lcm_, channels.status, this);
    Subscribe<&Listener::OnReply>(lcm_, channels.reply, this);
  }

  void Run(std::optional<Clock::time_point> end) {
    constexpr int kPatienceMs = 100;
    while (!Interrupted() && (!end || Clock::now() < *end)) {
      HandleFor(lcm_, kPatienceMs);
      // Once a second is enough for a reader; small changes add up.
      if (Clock::now() >= map_due_) SayWhatChanged();
    }
    SayWhatChanged();
    if (!heard_) std::printf("nothing was heard\n");
  }

 private:
  void Say(const char* what, const std::string& text) {
    std::printf("%-8s %s\n", what, text.c_str());
    std::fflush(stdout);
    heard_ = true;
  }

  void SayWhatChanged() {
    const TerrainMapPtr map = terrain_.map();
    if (map == map_) return;
    for (const std::string& sentence : ChangesInWords(map_, *map)) Say("map", sentence);
    map_ = map;
    map_due_ = Clock::now() + std::chrono::seconds(1);
  }

  void OnPose(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto message = SafeDecode<pose_t>(buffer->data, buffer->data_size);
    const auto T_world_body = message ? FromMessage(*message) : std::nullopt;
    if (!T_world_body || Clock::now() < pose_due_) return;
    pose_due_ = Clock::now() + std::chrono::seconds(1);
    Say("pose", PoseInWords(*T_world_body, {message->vel[0], message->vel[1], message->vel[2]}));
  }

  void OnStatus(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto message = SafeDecode<status_v1_t>(buffer->data, buffer->data_size);
    const auto status = message ? FromMessage(*message) : std::nullopt;
    if (status) Say("status", StatusInWords(*status));
  }

  void OnReply(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto message = SafeDecode<command_reply_v1_t>(buffer->data, buffer->data_size);
    // To our own request for a snapshot there is no need for words.
    if (message && message->message != "sent") Say("reply", message->message);
  }

  lcm::LCM* const lcm_;
  TerrainClient terrain_;
  TerrainMapPtr map_;
  Clock::time_point map_due_;
  Clock::time_point pose_due_;
  bool heard_ = false;
};

void Listen(const ListenOptions& options) {
  CatchInterrupts();
  lcm::LCM lcm(options.url);
  RequireOpen(lcm, options.url);
  std::optional<Clock::time_point> end;
  if (options.seconds > 0.0) {
    end = Clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * options.seconds));
  }
  Listener listener(&lcm);
  // Said once everything is subscribed, so that a program that starts this one knows that nothing is missed
  // from here on.
  std::printf("%-8s listening on %s\n", "bus", options.url.c_str());
  std::fflush(stdout);
  listener.Run(end);
}

}  // namespace

void AddListenCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("listen", "Say in words what a daemon publishes: pose, status, map, staircases");
  auto options = std::make_shared<ListenOptions>();
  command->add_option("--url", options->url, "LCM provider")->capture_default_str();
  command->add_option("--seconds", options->seconds, "end after this time; 0: at Ctrl-C")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->callback([options] { Listen(*options); });
}

}  // namespace terrace
