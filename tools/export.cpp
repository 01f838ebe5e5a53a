// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "client/terrace_file.h"
#include "core/file_bytes.h"
#include "tools/commands.h"
#include "tools/map_export.h"
#include "tools/result_server.h"

namespace terrace {
namespace {

struct ExportOptions {
  std::string result;
  std::string format;
  std::string output;
  double voxel_m = 0.02;
};

std::string ExportedBytes(const TerrainMap& map, const ExportOptions& options) {
  if (options.format == "ply") return PlyBytes(map);
  if (options.format == "glb") return GlbBytes(map);
  if (options.format == "json") return GeoJsonText(map);
  if (options.format == "ot") return OctomapText(map, options.voxel_m, OctomapFormat::kOt);
  if (options.format == "bt") return OctomapText(map, options.voxel_m, OctomapFormat::kBt);
  const std::vector<std::uint8_t> bytes = TerraceFileBytes(map);
  return {bytes.begin(), bytes.end()};
}

void Export(const ExportOptions& options) {
  const std::filesystem::path result(options.result);
  const TerrainMapPtr map = MapToServe(result);
  std::filesystem::path output(options.output);
  if (output.empty()) output = result.lexically_normal().filename().replace_extension("." + options.format);
  if (output == result) throw UsageError("the map would be written onto itself: name another file");
  const std::string bytes = ExportedBytes(*map, options);
  WriteFileBytes(output, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  std::printf("%s: %zu regions, %zu bytes\n", output.c_str(), map->regions.size(), bytes.size());
}

}  // namespace

void AddExportCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("export", "Write the map of a result as a file that other programs read");
  auto options = std::make_shared<ExportOptions>();
  command->add_option("RESULT", options->result, "folder that `terraced replay` wrote, or a .terrace file")
      ->required();
  command
      ->add_option(
          "FORMAT", options->format,
          "terrace: exact; ply, glb: triangles by label; json: polygons as in GeoJSON, in metres; ot, bt: "
          "OctoMap, voxels that the regions pass through")
      ->required()
      ->check(CLI::IsMember({"terrace", "ply", "glb", "json", "ot", "bt"}));
  command->add_option("OUT", options->output, "file to write; else named after RESULT, where you are");
  command->add_option("--voxel", options->voxel_m, "edge of a voxel in metres, for ot and bt")
      ->check(CLI::Range(0.005, 1.0))
      ->capture_default_str();
  command->callback([options] { Export(*options); });
}

}  // namespace terrace
