// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "core/file_bytes.h"
#include "evaluation/evaluation.h"
#include "evaluation/evaluation_text.h"
#include "evaluation/feet_picture.h"
#include "evaluation/report.h"
#include "evaluation/yardstick.h"
#include "tools/commands.h"
#include "tools/evaluate_all.h"
#include "tools/view_page.h"
#include "tools/view_report.h"
#include "tools/view_truth.h"

namespace terrace {
namespace {

constexpr const char* kViewName = "view.html";

struct EvaluateArguments {
  std::vector<std::string> result_and_sequence;
  std::vector<std::string> pair;
  std::optional<double> scale;
  std::optional<std::string> mask;
  std::vector<std::string> include;
  std::string run;
  std::string list;
  std::vector<std::string> families;
  std::string seeds = "1-4";
  std::string output;
  std::string baseline;
  std::string write_baseline;
  int num_jobs = 1;
  bool no_run = false;
  bool skip_missing = false;
  bool yardstick = false;
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

/// A page to look around in, with the truth; false: there is none, and why is said.
bool WriteView(const Evaluation& evaluation) {
  try {
    const ReplayResult result = ReadReplayResult(evaluation.result);
    ViewBeside beside;
    beside.rows = RowsOfTruth(evaluation);
    WriteText(evaluation.result / kViewName, ReportPage(ReadViewPage(), result, {evaluation.sequence},
                                                        std::move(beside), RecordsOfTruth(evaluation)));
    return true;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "no page to look around in: %s\n", error.what());
    return false;
  }
}

void EvaluateFolder(const EvaluateArguments& arguments) {
  const std::filesystem::path result = arguments.result_and_sequence[0];
  const Evaluation evaluation =
      EvaluateResult(result, arguments.result_and_sequence[1], OptionsOf(arguments.include));
  WriteText(result / "evaluation.json", ToJson(evaluation));
  const bool has_view = WriteView(evaluation);
  WriteText(result / "report.html", ToReport(evaluation, has_view ? kViewName : ""));
  const ColourImage feet = evaluation.feet ? PictureOfFeet(*evaluation.feet) : ColourImage{};
  if (!feet.data.empty()) WriteFileBytes(result / "feet.png", EncodePng(feet));
  std::fputs(ToTable(evaluation).c_str(), stdout);
  if (arguments.yardstick)
    std::fputs(ToTable(EvaluateYardstick(result, arguments.result_and_sequence[1])).c_str(), stdout);
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

void EvaluateList(const EvaluateArguments& arguments) {
  EvaluateAllArguments all;
  all.list = arguments.list;
  all.families = arguments.families;
  all.seeds = arguments.seeds;
  all.output = arguments.output;
  all.num_jobs = arguments.num_jobs;
  all.run = !arguments.no_run;
  all.skip_missing = arguments.skip_missing;
  if (!arguments.baseline.empty()) all.baseline = arguments.baseline;
  if (!arguments.write_baseline.empty()) all.write_baseline = arguments.write_baseline;
  if (!EvaluateAll(all)) throw std::runtime_error("evaluate --all: something failed or got worse");
}

void Run(const EvaluateArguments& arguments) {
  const bool one_result = !arguments.result_and_sequence.empty();
  const int num_ways = one_result + !arguments.pair.empty() + !arguments.run.empty() +
                       !arguments.list.empty() + !arguments.families.empty();
  if (num_ways != 1 || (one_result && arguments.result_and_sequence.size() != 2)) {
    throw UsageError(
        "evaluate wants one of: RESULT_DIR SEQUENCE, --pair D TRUTH, --run LINE, --all LIST, --family NAME");
  }
  const bool many = !arguments.list.empty() || !arguments.families.empty();
  if ((!arguments.run.empty() || many) && arguments.output.empty()) {
    throw UsageError("evaluate: --run, --all and --family want --output DIR");
  }
  if (one_result) return EvaluateFolder(arguments);
  if (!arguments.pair.empty()) return EvaluatePair(arguments);
  if (many) return EvaluateList(arguments);
  RunJob(ParseJob(arguments.run, "--run"), std::filesystem::current_path(), arguments.output);
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("evaluate", "Measure a replay, or one disparity image, against the truth");
  auto arguments = std::make_shared<EvaluateArguments>();
  command->add_option("RESULT_DIR SEQUENCE", arguments->result_and_sequence,
                      "what terraced replay wrote, and what it read; writes RESULT_DIR/evaluation.json, "
                      "report.html, view.html and feet.png");
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
  command->add_option(
      "--run", arguments->run,
      "replay and evaluate one line of a list: \"name sequence [options of terraced replay]\"");
  CLI::Option* all =
      command->add_option("--all", arguments->list, "replay and evaluate every line of a list");
  CLI::Option* family =
      command
          ->add_option("--family", arguments->families,
                       "replay and evaluate places of these families of scenes, or of all; prints one table")
          ->delimiter(',')
          ->excludes(all);
  command->add_option("--seeds", arguments->seeds, "of --family: ONE or FIRST-LAST")
      ->capture_default_str()
      ->needs(family);
  command->add_option("--output", arguments->output, "of --run, --all and --family: results go to DIR/name")
      ->type_name("DIR");
  command->add_option("--jobs", arguments->num_jobs, "sequences at a time")->check(CLI::Range(1, 1024));
  command
      ->add_option("--baseline", arguments->baseline,
                   "stored figures to compare with; exit code 1 when worse")
      ->type_name("FILE")
      ->needs(all);
  command->add_option("--write-baseline", arguments->write_baseline, "store the figures here")
      ->type_name("FILE")
      ->needs(all);
  command->add_flag("--no-run", arguments->no_run, "compare the results that are already in DIR");
  command->add_flag("--skip-missing", arguments->skip_missing, "leave out sequences that are not here")
      ->needs(all);
  command->add_flag("--yardstick", arguments->yardstick,
                    "beside RESULT_DIR's footholds those of an elevation map, fed with its disparity images");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace terrace
