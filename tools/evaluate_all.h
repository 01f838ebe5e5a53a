// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terrace {

/// One line of a list: `name sequence [options of terraced replay]`. The sequence is a path, or
/// `scene:NAME[,option=value]...`, which `terrace synthesize NAME` renders first with those options.
struct EvaluationJob {
  std::string name;
  std::string sequence;
  std::vector<std::string> replay_options;
};

/// Throws FileError, naming `where`, when the line is not of that form.
EvaluationJob ParseJob(const std::string& line, const std::string& where);

struct EvaluateAllArguments {
  std::filesystem::path list;
  std::filesystem::path output;
  int num_jobs = 1;
  bool run = true;            ///< false: compare the results that are there
  bool skip_missing = false;  ///< a sequence that is not here is left out, not failed
  std::optional<std::filesystem::path> baseline;
  std::optional<std::filesystem::path> write_baseline;
};

/// Replays and evaluates one sequence into output/NAME; each step is a process of its own. Throws
/// std::runtime_error when a step fails.
void RunJob(const EvaluationJob& job, const std::filesystem::path& base, const std::filesystem::path& output);

/// Runs every line of the list, prints the table of all; false when something failed or got worse than the
/// baseline allows.
bool EvaluateAll(const EvaluateAllArguments& arguments);

}  // namespace terrace
