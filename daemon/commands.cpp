// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands.h"

#include <array>
#include <charconv>
#include <chrono>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include <spdlog/spdlog.h>

#include "client/terrace_file.h"
#include "core/file_bytes.h"
#include "daemon/result_writer.h"
#include "results/map_file.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

// The results of a run, which a saved map must not replace.
constexpr std::array<std::string_view, 8> kResultFiles{
    "trajectory.tum", "terrain_map.json", "frames.jsonl", "staircases.jsonl",
    "camera.json",    "stats.json",       "tracks.jsonl", "explanations.jsonl"};

command_reply_v1_t Reply(std::int8_t result, std::string message) {
  command_reply_v1_t reply{};
  reply.result = result;
  reply.message = std::move(message);
  return reply;
}
command_reply_v1_t Ok(std::string message) { return Reply(command_reply_v1_t::OK, std::move(message)); }
command_reply_v1_t Refused(std::string message) {
  return Reply(command_reply_v1_t::REFUSED, std::move(message));
}
command_reply_v1_t Failed(std::string message) {
  return Reply(command_reply_v1_t::FAILED, std::move(message));
}

/// The name may not lead out of the folder, nor onto anything that is there and is no file.
std::string ProblemOfName(const fs::path& folder, const std::string& name) {
  if (name.empty() || name.find('/') != std::string::npos || name.find('\0') != std::string::npos ||
      name == "." || name == "..")
    return "argument '" + name + "' must be the name of a file, without a folder";
  for (const std::string_view file : kResultFiles)
    if (name == file) return "'" + name + "' belongs to the results of the run: choose another name";
  std::error_code error;
  const fs::file_status there = fs::symlink_status(folder / name, error);
  if (fs::exists(there) && !fs::is_regular_file(there)) return "'" + name + "' is there and is no file";
  return "";
}

}  // namespace

command_reply_v1_t CommandObeyer::Obey(const command_v1_t& command) {
  switch (command.command) {
    case command_v1_t::RESET_MAP:
      actions_.reset_map();
      spdlog::info("the map begins anew, as commanded");
      return Ok("the map begins anew with the next frame");
    case command_v1_t::PAUSE:
      actions_.pause_map(true);
      spdlog::info("paused, as commanded");
      return Ok("paused: poses go on, nothing is mapped until RESUME");
    case command_v1_t::RESUME:
      actions_.pause_map(false);
      spdlog::info("resumed, as commanded");
      return Ok("resumed");
    case command_v1_t::SAVE_MAP:
      return SaveMap(command.argument);
    case command_v1_t::LOAD_MAP:
      return LoadMap(command.argument);
    case command_v1_t::SEND_SNAPSHOT:
      return actions_.send_snapshot() ? Ok("sent") : Refused("there is no map yet");
    case command_v1_t::EXPLAIN:
      return Explain(command.argument);
    case command_v1_t::RELOAD_CONFIG:
      return Refused("settings are read at the start: restart the daemon");
    default:
      return Refused("no such command: " + std::to_string(command.command));
  }
}

command_reply_v1_t CommandObeyer::Explain(const std::string& argument) const {
  std::int64_t id = 0;
  const char* const end = argument.data() + argument.size();
  const auto [read, error] = std::from_chars(argument.data(), end, id);
  if (error != std::errc() || read != end)
    return Refused("argument '" + argument + "' must be the id of a region or staircase");
  const Explanations explanations = actions_.explain(id);
  std::string text;
  for (const RegionExplanation& region : explanations.regions) text += region.text + '\n';
  for (const StaircaseExplanation& staircase : explanations.staircases) text += staircase.text + '\n';
  if (text.empty()) return Refused("the map has neither a region nor a staircase " + argument);
  text.pop_back();
  return Ok(std::move(text));
}

command_reply_v1_t CommandObeyer::LoadMap(const std::string& argument) const {
  if (save_folder_.empty()) return Refused("set lcm.save_folder, the folder that maps are in");
  const std::string name = argument.substr(0, argument.find(' '));
  const std::string where = argument.substr(name.size());
  const std::string problem = ProblemOfName(save_folder_, name);
  if (!problem.empty()) return Refused(problem);
  const std::optional<BodyInMap> body = BodyInMapFrom(where);
  if (!body && where.find_first_not_of(' ') != std::string::npos)
    return Refused(
        "behind the file's name must stand where the body is in that map, x y z in metres and yaw "
        "in degrees, or nothing; not '" +
        where.substr(1) + "'");
  try {
    SavedMap saved = LoadTerraceFile(save_folder_ / name);
    const std::size_t num_regions = saved.map->regions.size();
    const std::size_t num_views = saved.views.size();
    if (!actions_.load_map(std::move(saved), name, body)) return Refused("no camera is known yet: ask again");
    spdlog::info("{} is loaded, as commanded", name);
    std::string next = "it is put into the world with the next pose";
    if (!body)
      next = num_views > 0 ? "it stands by itself until the robot is recognised in one of its " +
                                 std::to_string(num_views) + " views, or somebody says where it is"
                           : "it stands by itself until somebody says where the robot is in it";
    return Ok(name + " is loaded, with " + std::to_string(num_regions) + " regions; " + next);
  } catch (const FileError& error) {
    return Refused(error.what());
  }
}

command_reply_v1_t CommandObeyer::SaveMap(const std::string& name) const {
  if (save_folder_.empty()) return Refused("set lcm.save_folder, the folder to save maps into");
  const std::string problem = ProblemOfName(save_folder_, name);
  if (!problem.empty()) return Refused(problem);
  const SavedMap saved = actions_.map();
  if (!saved.map) return Refused("there is no map yet");
  const fs::path file = save_folder_ / name;
  if (file.extension() == ".terrace") {
    try {
      SaveTerraceFile(file, *saved.map, saved.views);
      return Ok(file.string());
    } catch (const FileError& error) {
      return Failed(error.what());
    }
  }
  // Under another name until it is whole, so that no half file is ever there.
  const fs::path partial = save_folder_ / (name + ".partial");
  std::error_code error;
  {
    std::ofstream out(partial, std::ios::binary | std::ios::trunc);
    out << TerrainMapJson(*saved.map);
    out.close();
    if (out) fs::rename(partial, file, error);
    if (out && !error) return Ok(file.string());
  }
  fs::remove(partial, error);
  return Failed(file.string() + ": cannot be written");
}

}  // namespace terrace
