// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "datasets/file_bytes.h"
#include "evaluation/evaluation.h"
#include "evaluation/evaluation_text.h"
#include "evaluation/report.h"
#include "tools/commands.h"

namespace terrace {
namespace {

struct EvaluateArguments {
  std::vector<std::string> result_and_sequence;
  std::vector<std::string> pair;
  std::optional<double> scale;
  std::optional<std::string> mask;
  std::vector<std::string> include;
};

void WriteText(const std::filesystem::path& path, const std::string& text) {
  WriteFileBytes(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

MapEvaluationOptions OptionsOf(const std::vector<std::string>& include) {
  MapEvaluationOptions options;
  for (const std::string& name : include) {
    if (name == "other") options.include_other = true;
    if (name == "detail") options.include_detail = true;
  }
  return options;
}

void EvaluateFolder(const EvaluateArguments& arguments) {
  const std::filesystem::path result = arguments.result_and_sequence[0];
  const Evaluation evaluation =
      EvaluateResult(result, arguments.result_and_sequence[1], OptionsOf(arguments.include));
  WriteText(result / "evaluation.json", ToJson(evaluation));
  WriteText(result / "report.html", ToReport(evaluation));
  std::fputs(ToTable(evaluation).c_str(), stdout);
}

void EvaluatePair(const EvaluateArguments& arguments) {
  const DisparityTruth truth =
      LoadPairTruth(arguments.pair[1], arguments.scale,
                    arguments.mask ? std::optional<std::filesystem::path>(*arguments.mask) : std::nullopt);
  DisparityErrors errors;
  errors.Add(ReadDisparityFile(arguments.pair[0]), truth);
  std::fputs(ToTable(errors).c_str(), stdout);
  std::fputs(ToJson(errors).c_str(), stdout);  // last line, for programs
}

void Run(const EvaluateArguments& arguments) {
  if (!arguments.pair.empty()) return EvaluatePair(arguments);
  if (arguments.result_and_sequence.size() != 2) {
    throw UsageError("evaluate wants RESULT_DIR SEQUENCE, or --pair D TRUTH");
  }
  EvaluateFolder(arguments);
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("evaluate", "Measure a replay, or one disparity image, against the truth");
  auto arguments = std::make_shared<EvaluateArguments>();
  command->add_option(
      "RESULT_DIR SEQUENCE", arguments->result_and_sequence,
      "what terraced replay wrote, and what it read; writes RESULT_DIR/evaluation.json and report.html");
  command->add_option("--include", arguments->include, "true polygons to ask for besides the ordinary ones")
      ->check(CLI::IsMember({"other", "detail"}))
      ->delimiter(',');
  CLI::Option* pair =
      command->add_option("--pair", arguments->pair, "a disparity image and its truth, .pfm or .png")
          ->type_name("D TRUTH")
          ->expected(2);
  command->add_option("--scale", arguments->scale, "values of TRUTH per pixel of disparity")
      ->check(CLI::PositiveNumber)
      ->needs(pair);
  command->add_option("--mask", arguments->mask, "255 visible in both images, 128 hidden in the right one")
      ->needs(pair);
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace terrace
