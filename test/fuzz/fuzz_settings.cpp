// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/terrace_file.h"
#include "core/file_bytes.h"
#include "daemon/commands.h"
#include "daemon/config.h"
#include "datasets/synthetic/scene_file.h"
#include "test/fuzz/fuzz_folder.h"
#include "test/fuzz/fuzz_targets.h"
#include "tools/camera_config.h"

namespace terrace::fuzz {
namespace {

void ReadConfig(Bytes bytes) {
  try {
    LoadConfig(Written("config.yaml", bytes), {});
  } catch (const ConfigError&) {
  }
}

void ReadSetting(Bytes bytes) {
  try {
    LoadConfig(std::nullopt, {std::string(bytes.begin(), bytes.end())});
  } catch (const ConfigError&) {
  }
}

void ReadCamera(Bytes bytes) {
  try {
    ReadCameraConfig(Written("camera.yaml", bytes));
  } catch (const FileError&) {
  }
}

void ReadScene(Bytes bytes) {
  try {
    synthetic::LoadScene(Written("scene.yaml", bytes));
  } catch (const synthetic::SceneError&) {
  }
}

/// Puts size and checksum right: nobody guesses eight bytes of a sum.
void ReadTerraceFile(Bytes bytes) {
  constexpr std::size_t kSizeAt = 16, kSumAt = 24, kHeader = 32;
  // Of a file without views, or with some.
  std::vector<std::uint8_t> file = TerraceFileBytes(TerrainMap(), std::vector<PlaceView>(bytes.size() % 2));
  file.resize(kHeader);
  file.insert(file.end(), bytes.begin(), bytes.end());
  file.resize((file.size() + 7) / 8 * 8);
  const std::uint64_t size = file.size();
  std::memcpy(file.data() + kSizeAt, &size, sizeof(size));
  std::uint64_t sum = 0xcbf29ce484222325u;
  for (std::size_t at = 0; at < file.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, file.data() + at, sizeof(word));
    if (at != kSumAt) sum = (sum ^ word) * 0x100000001b3u;
  }
  std::memcpy(file.data() + kSumAt, &sum, sizeof(sum));
  try {
    FromTerraceFile(file, "file");
  } catch (const FileError&) {
  }
}

/// A daemon with an empty map is told things; files that it saves and loads stay in this process's folder.
void ObeyCommand(Bytes bytes) {
  if (bytes.empty()) return;
  const CommandActions actions = {
      [] {},
      [](bool) {},
      [] { return true; },
      [] { return SavedMap{std::make_shared<const TerrainMap>(), {}}; },
      [](std::int64_t) { return Explanations{}; },
      [](const SavedMap&, const std::string&, const std::optional<BodyInMap>&) { return true; }};
  const std::filesystem::path saved = Folder() / "saved";
  std::filesystem::create_directories(saved);
  CommandObeyer obeyer(saved, actions);
  command_v1_t command{};
  command.command = static_cast<std::int8_t>(bytes[0]);
  command.argument.assign(bytes.begin() + 1, bytes.end());
  obeyer.Obey(command);
}

}  // namespace

std::vector<Target> SettingTargets() {
  return {{"config", ReadConfig}, {"setting", ReadSetting},          {"camera", ReadCamera},
          {"scene", ReadScene},   {"terrace_file", ReadTerraceFile}, {"obey", ObeyCommand}};
}

}  // namespace terrace::fuzz
