// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

#include "results/explanations_file.h"
#include "tools/commands.h"

namespace terrace {
namespace {

struct ExplainOptions {
  std::string result;
  std::int64_t id = 0;
};

void Explain(const ExplainOptions& options) {
  const Explanations all = ReadExplanationsFile(std::filesystem::path(options.result) / "explanations.jsonl");
  // A region and a staircase may have the same id.
  bool any = false;
  const auto say = [&](std::int64_t id, const std::string& text) {
    if (id != options.id) return;
    any = true;
    std::printf("%s\n", text.c_str());
  };
  for (const RegionExplanation& region : all.regions) say(region.id, region.text);
  for (const StaircaseExplanation& staircase : all.staircases) say(staircase.id, staircase.text);
  if (!any)
    throw std::runtime_error(options.result + ": its map has neither a region nor a staircase " +
                             std::to_string(options.id));
}

}  // namespace

void AddExplainCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "explain",
      "Say why a region has its label, or why there is a staircase, and what else it could have been");
  auto options = std::make_shared<ExplainOptions>();
  command->add_option("RESULT", options->result, "a folder that a replay wrote")->required();
  command->add_option("ID", options->id, "of a region or a staircase, as terrain_map.json has it")
      ->required();
  command->callback([options] { Explain(*options); });
}

}  // namespace terrace
