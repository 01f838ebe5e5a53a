// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "core/time.h"
#include "datasets/sequence.h"
#include "tools/commands.h"

namespace terrace {
namespace {

void DescribeSequence(const std::filesystem::path& path) {
  const SequenceInfo info = OpenSequence(path)->info();
  const double duration_s = Seconds(info.t_last - info.t_first);
  std::printf("%s: %s\n", path.c_str(), Name(info.kind));
  std::printf("  %lld stereo frames of %dx%d over %.1f s\n", static_cast<long long>(info.num_frames),
              info.calibration.width, info.calibration.height, duration_s);
  for (const std::string& warning : info.warnings) std::printf("  note: %s\n", warning.c_str());
}

}  // namespace

void AddInfoCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("info", "Say in words what a sequence, result folder, map or image holds");
  auto path = std::make_shared<std::string>();
  command->add_option("FILE", *path, "file or folder")->required();
  command->callback([path] { DescribeSequence(*path); });
}

}  // namespace terrace
