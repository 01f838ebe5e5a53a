// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terrace {

/// One line of a list: `name sequence [options of terraced replay]`. The sequence is a path, or
/// `scene:NAME[,option=value]...`, which `terrace synthesize NAME` renders first with those options. A line
/// of a family (tools/family_jobs.h) becomes many jobs.
struct EvaluationJob {
  std::string name;
  std::string sequence;
  std::vector<std::string> replay_options;
  std::string group;  ///< the line that this is a place of; empty: none
};

/// Throws FileError, naming `where`, when the line is not of that form.
EvaluationJob ParseJob(const std::string& line, const std::string& where);

struct EvaluateAllArguments {
  std::filesystem::path list;         ///< empty: the families
  std::vector<std::string> families;  ///< by name, or "all"
  std::string seeds;                  ///< of the families: ONE or FIRST-LAST
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

/// Runs every line of the list, or every place of the families; prints the table of all, and one of families.
/// False when something failed or got worse than the baseline allows.
bool EvaluateAll(const EvaluateAllArguments& arguments);

}  // namespace terrace
