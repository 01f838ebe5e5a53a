// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <lcm/lcm-cpp.hpp>
#include <terrace/command_reply_v1_t.hpp>
#include <terrace/command_v1_t.hpp>

#include "daemon/interrupt.h"
#include "lcmtypes/open_bus.h"
#include "lcmtypes/safe_decode.h"
#include "lcmtypes/subscribe.h"
#include "tools/bus.h"
#include "tools/commands.h"

namespace terrace {
namespace {

struct CommandOptions {
  BusOptions bus;
  std::string name;
  std::string argument;
  double wait_s = 5.0;
};

constexpr std::array<std::pair<const char*, std::int8_t>, 9> kCommands{
    std::pair{"reset_map", command_v1_t::RESET_MAP},
    {"pause", command_v1_t::PAUSE},
    {"resume", command_v1_t::RESUME},
    {"save_map", command_v1_t::SAVE_MAP},
    {"load_map", command_v1_t::LOAD_MAP},
    {"send_snapshot", command_v1_t::SEND_SNAPSHOT},
    {"explain", command_v1_t::EXPLAIN},
    {"reload_config", command_v1_t::RELOAD_CONFIG},
    {"keep_record", command_v1_t::KEEP_RECORD}};

/// As people type it: SAVE_MAP, save_map or save-map.
std::int8_t CommandNumber(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return c == '-' ? '_' : static_cast<char>(std::tolower(c)); });
  std::string known;
  for (const auto& [command, number] : kCommands) {
    if (name == command) return number;
    known += (known.empty() ? "" : ", ") + std::string(command);
  }
  throw UsageError("no such command: " + name + "; there are " + known);
}

/// Keeps the reply to one request.
class ReplyListener {
 public:
  ReplyListener(lcm::LCM* lcm, const std::string& channel, std::int64_t request_id)
      : request_id_(request_id) {
    Subscribe<&ReplyListener::OnReply>(lcm, channel, this);
  }
  const std::optional<command_reply_v1_t>& reply() const { return reply_; }

 private:
  void OnReply(const lcm::ReceiveBuffer* buffer, const std::string&) {
    const auto message = SafeDecode<command_reply_v1_t>(buffer->data, buffer->data_size);
    if (message && message->request_id == request_id_) reply_ = message;
  }

  const std::int64_t request_id_;
  std::optional<command_reply_v1_t> reply_;
};

void SendCommand(const CommandOptions& options) {
  command_v1_t command{};
  command.command = CommandNumber(options.name);
  command.argument = options.argument;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  command.utime = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  std::random_device random;
  command.request_id = static_cast<std::int64_t>(random()) << 16 ^ static_cast<std::int64_t>(random());

  const Config config = ConfigOf(options.bus);
  CatchInterrupts();
  lcm::LCM lcm(config.live.url);
  RequireOpen(lcm, config.live.url);
  const ReplyListener listener(&lcm, config.channels.reply, command.request_id);
  lcm.publish(config.channels.command, &command);
  constexpr int kStepMs = 50;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.wait_s);
  while (!listener.reply() && !Interrupted() && std::chrono::steady_clock::now() < end)
    HandleFor(&lcm, kStepMs);
  if (!listener.reply())
    throw std::runtime_error("no reply on " + config.channels.reply + ": does a daemon run there?");
  if (listener.reply()->result != command_reply_v1_t::OK) {
    const char* result = listener.reply()->result == command_reply_v1_t::REFUSED ? "refused" : "failed";
    throw std::runtime_error(std::string(result) + ": " + listener.reply()->message);
  }
  std::printf("%s\n", listener.reply()->message.c_str());
}

}  // namespace

void AddCommandCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "command", "Tell a daemon what to do and wait for its reply; exit code 0 when it has obeyed, else 1");
  auto options = std::make_shared<CommandOptions>();
  AddBusOptions(command, &options->bus);
  command
      ->add_option(
          "NAME", options->name,
          "reset_map, pause, resume, save_map, load_map, send_snapshot, explain, reload_config; keep_record, "
          "to terrace record")
      ->required();
  command->add_option(
      "ARGUMENT", options->argument,
      "save_map: the name of the file; load_map: the same (NAME.terrace), and, when it is known, "
      "where the body is in it: \"NAME.terrace x y z yaw\", metres and degrees; explain: the id of a region "
      "or staircase; "
      "keep_record: a word for its name");
  command->add_option("--wait", options->wait_s, "for the reply, in seconds")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command->callback([options] { SendCommand(*options); });
}

}  // namespace terrace
