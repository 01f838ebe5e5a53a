// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate_all.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include <fcntl.h>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/file_bytes.h"
#include "evaluation/baseline.h"
#include "evaluation/family_table.h"
#include "tools/family_jobs.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScenePrefix = "scene:";

fs::path OwnProgram() { return fs::read_symlink("/proc/self/exe"); }

/// `terraced` beside `terrace` when installed, else where the build leaves it.
fs::path Daemon() {
  const fs::path folder = OwnProgram().parent_path();
  for (const fs::path& candidate : {folder / "terraced", folder.parent_path() / "daemon" / "terraced"}) {
    if (fs::is_regular_file(candidate)) return candidate;
  }
  throw std::runtime_error("terraced is neither in " + folder.string() + " nor in ../daemon");
}

/// Starts a program; its output goes to the end of `log` when one is given.
pid_t Start(const std::vector<std::string>& command, const std::optional<fs::path>& log) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (log) {
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log->c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                     0644);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  }
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error(command[0] + " cannot be started: " + std::strerror(error));
  return pid;
}

void RunOrThrow(const std::vector<std::string>& command) {
  std::string line = "$";
  for (const std::string& word : command) line += " " + word;
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
  int status = 0;
  if (waitpid(Start(command, std::nullopt), &status, 0) < 0 || !WIFEXITED(status) ||
      WEXITSTATUS(status) != 0) {
    throw std::runtime_error("failed: " + line);
  }
}

bool IsScene(const EvaluationJob& job) { return job.sequence.rfind(kScenePrefix, 0) == 0; }

/// Where the recording lies: as given, in the folder of recordings, or beside the list.
std::optional<fs::path> Find(const EvaluationJob& job, const fs::path& base) {
  std::vector<fs::path> candidates{job.sequence};
  if (const char* data = std::getenv("TERRACE_DATA")) candidates.push_back(fs::path(data) / job.sequence);
  candidates.push_back(base / job.sequence);
  for (const fs::path& candidate : candidates) {
    if (fs::exists(candidate)) return candidate;
  }
  return std::nullopt;
}

/// Keeps other processes out while it lives.
class FileLock {
 public:
  explicit FileLock(const fs::path& path) : file_(open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644)) {
    if (file_ < 0 || flock(file_, LOCK_EX) != 0)
      throw FileError(path.string() + ": cannot be locked: " + std::strerror(errno));
  }
  ~FileLock() { close(file_); }
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int file_;
};

/// Renders the scene unless an earlier run or another job did. The folder gets its name when it is complete.
fs::path Render(const EvaluationJob& job, const fs::path& output) {
  const std::string description = job.sequence.substr(std::strlen(kScenePrefix));
  const fs::path folder = output / "sequences" / description;
  fs::create_directories(folder.parent_path());
  const FileLock lock(folder.string() + ".lock");
  if (fs::exists(folder)) return folder;
  std::istringstream parts(description);
  std::string scene, option;
  std::getline(parts, scene, ',');
  const fs::path partial = folder.string() + ".partial";
  std::vector<std::string> command{OwnProgram(), "synthesize", scene, partial, "--overwrite"};
  while (std::getline(parts, option, ',')) {
    const std::size_t equals = option.find('=');
    if (equals == std::string::npos) throw FileError(job.sequence + ": '" + option + "' is not option=value");
    command.push_back("--" + option.substr(0, equals));
    command.push_back(option.substr(equals + 1));
  }
  RunOrThrow(command);
  fs::rename(partial, folder);
  return folder;
}

/// Appends the jobs of a line.
void AddJobs(const EvaluationJob& line, const std::string& where, std::vector<EvaluationJob>* jobs) {
  for (EvaluationJob& job : ExpandFamily(line, where)) {
    const bool again = std::any_of(jobs->begin(), jobs->end(),
                                   [&](const EvaluationJob& other) { return other.name == job.name; });
    if (again) throw FileError(where + ": the name '" + job.name + "' is used twice");
    jobs->push_back(std::move(job));
  }
}

std::vector<EvaluationJob> ReadList(const fs::path& list) {
  std::vector<EvaluationJob> jobs;
  std::istringstream in(ReadTextFile(list));
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const std::string where = list.string() + ":" + std::to_string(number);
    AddJobs(ParseJob(line, where), where, &jobs);
  }
  return jobs;
}

std::vector<EvaluationJob> JobsOf(const EvaluateAllArguments& arguments) {
  if (!arguments.list.empty()) return ReadList(arguments.list);
  std::vector<EvaluationJob> jobs;
  for (const EvaluationJob& line : FamilyLines(arguments.families, arguments.seeds))
    AddJobs(line, "--seeds", &jobs);
  return jobs;
}

std::string Line(const EvaluationJob& job) {
  std::string line = job.name + " " + job.sequence;
  for (const std::string& option : job.replay_options) line += " " + option;
  return line;
}

/// Runs the jobs as processes, `num_jobs` at a time; returns the names of those that failed.
std::set<std::string> RunJobs(std::vector<EvaluationJob> jobs, const EvaluateAllArguments& arguments) {
  std::set<std::string> failed;
  std::map<pid_t, std::string> running;
  const auto wait_for_one = [&] {
    int status = 0;
    const pid_t pid = waitpid(-1, &status, 0);
    const auto job = running.find(pid);
    if (job == running.end()) throw std::runtime_error("a job was lost");
    const bool done = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    const fs::path log = arguments.output / (job->second + ".log");
    std::printf("%-24s %s\n", job->second.c_str(), done ? "done" : ("failed, see " + log.string()).c_str());
    std::fflush(stdout);
    if (!done) failed.insert(job->second);
    running.erase(job);
  };
  for (EvaluationJob& job : jobs) {
    while (static_cast<int>(running.size()) >= arguments.num_jobs) wait_for_one();
    if (!IsScene(job)) job.sequence = fs::absolute(*Find(job, arguments.list.parent_path()));
    const fs::path log = arguments.output / (job.name + ".log");
    fs::remove(log);
    running[Start({OwnProgram(), "evaluate", "--run", Line(job), "--output", arguments.output}, log)] =
        job.name;
  }
  while (!running.empty()) wait_for_one();
  return failed;
}

}  // namespace

EvaluationJob ParseJob(const std::string& line, const std::string& where) {
  std::istringstream words(line);
  EvaluationJob job;
  if (!(words >> job.name >> job.sequence)) {
    throw FileError(where + ": must be 'name sequence [options of terraced replay]'");
  }
  for (const char c : job.name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') {
      throw FileError(where + ": the name '" + job.name + "' must be of letters, digits, - and _");
    }
  }
  for (std::string word; words >> word;) job.replay_options.push_back(word);
  return job;
}

void RunJob(const EvaluationJob& job, const fs::path& base, const fs::path& output) {
  fs::path sequence;
  if (IsScene(job)) {
    sequence = Render(job, output);
  } else if (const std::optional<fs::path> found = Find(job, base)) {
    sequence = *found;
  } else {
    throw FileError(job.sequence + ": no such sequence");
  }
  const fs::path result = output / job.name;
  std::vector<std::string> replay{Daemon(), "replay", sequence, "--output", result, "--overwrite"};
  replay.insert(replay.end(), job.replay_options.begin(), job.replay_options.end());
  // For the film strip of the report.
  if (std::find(replay.begin(), replay.end(), "--save-tracks") == replay.end())
    replay.insert(replay.end(), {"--save-tracks", "8"});
  // A figure of an earlier run must not pass for one of this.
  fs::remove(result / "evaluation.json");
  fs::create_directories(output);
  RunOrThrow(replay);
  RunOrThrow({OwnProgram(), "evaluate", result, sequence});
}

bool EvaluateAll(const EvaluateAllArguments& arguments) {
  Baseline baseline;
  baseline.figures = DefaultFigures();
  if (arguments.baseline)
    baseline = ParseBaseline(ReadTextFile(*arguments.baseline), arguments.baseline->string());
  std::vector<EvaluationJob> jobs = JobsOf(arguments);
  std::set<std::string> failed;
  std::erase_if(jobs, [&](const EvaluationJob& job) {
    if (IsScene(job) || Find(job, arguments.list.parent_path())) return false;
    std::printf("%-24s not here: %s\n", job.name.c_str(), job.sequence.c_str());
    if (!arguments.skip_missing) failed.insert(job.name);
    return true;
  });
  fs::create_directories(arguments.output);
  if (arguments.run) failed.merge(RunJobs(jobs, arguments));

  std::map<std::string, Figures> measured;
  FamilyEvaluations families;
  for (const EvaluationJob& job : jobs) {
    const fs::path file = arguments.output / job.name / "evaluation.json";
    if (failed.contains(job.name)) continue;
    if (!fs::exists(file)) {
      failed.insert(job.name);
      continue;
    }
    const std::string text = ReadTextFile(file);
    measured[job.name] = FiguresOf(text, file.string(), baseline.figures);
    if (!job.group.empty()) families[job.group].push_back(text);
  }
  const BaselineComparison comparison = Compare(baseline, measured, {failed.begin(), failed.end()});
  std::fputs(comparison.table.c_str(), stdout);
  if (!families.empty()) std::printf("\n%s", TableOfFamilies(families).c_str());
  for (const std::string& sentence : comparison.worse) std::printf("worse: %s\n", sentence.c_str());
  if (arguments.write_baseline) {
    for (const auto& [name, figures] : measured) baseline.sequences[name] = figures;
    const std::string text = ToJson(baseline);
    WriteFileBytes(*arguments.write_baseline,
                   {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }
  return comparison.worse.empty();
}

}  // namespace terrace
