// SPDX-License-Identifier: BSD-3-Clause
// terraced: the stereo terrain mapper. Live by default, `terraced replay` for recorded sequences.

#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>

#include "core/standard_streams.h"
#include "daemon/config.h"
#include "daemon/interrupt.h"
#include "daemon/live.h"
#include "daemon/log_setup.h"
#include "daemon/replay.h"
#include "daemon/result_writer.h"
#include "daemon/version.h"
#include "datasets/sequence.h"

namespace terrace {
namespace {

// What the shell sees (DESIGN.md, "Command line").
constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

struct Arguments {
  std::optional<std::string> config_file;
  std::vector<std::string> settings;
  std::vector<std::string> map_settings;  // of --load-map and --map-pose; --set replaces what it finds
  bool print_config = false;
  std::string log_file;
  ReplayOptions replay;
  LiveOptions live;
};

void AddCommonOptions(CLI::App* app, Arguments* arguments) {
  app->add_option("--config", arguments->config_file, "YAML file that overrides any part of the defaults");
  const auto set = [arguments](const char* key) {
    return [arguments, key](const std::string& value) {
      arguments->map_settings.push_back(std::string(key) + "=" + value);
    };
  };
  app->add_option_function<std::string>("--load-map", set("lcm.load_map"),
                                        "Map to begin with, a .terrace file: same as lcm.load_map");
  app->add_option_function<std::string>("--map-pose", set("lcm.map_pose"),
                                        "\"x y z yaw\", where the body is in that map at the start: metres, "
                                        "degrees; same as lcm.map_pose");
  app->add_option("--set", arguments->settings, "Overrides one key: section.key=value (may be repeated)")
      ->allow_extra_args(false);
}

int Run(int argc, char** argv) {
  CLI::App app(
      "terraced turns a legged robot's stereo camera into a labelled map of planar terrain.\n"
      "Without a subcommand it runs live: LCM in, LCM out.");
  app.set_version_flag("--version", std::string("terraced ") + kVersion);
  Arguments arguments;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  arguments.replay.num_threads = arguments.live.num_threads = cores;

  AddCommonOptions(&app, &arguments);
  app.add_option("--log-file", arguments.log_file, "Log into this file as well; 10 MB each, five are kept");
  app.add_flag("--print-config", arguments.print_config, "Prints the complete configuration file and ends");
  app.add_option("--output", arguments.live.output, "Folder for the result files, written at the end");
  app.add_flag("--overwrite", arguments.live.overwrite,
               "Replace the results of an earlier run in that folder");
  app.add_option("--threads", arguments.live.num_threads, "Threads that may be used")
      ->check(CLI::Range(1, 256));
  CLI::App* replay = app.add_subcommand("replay", "Plays a recorded sequence and writes the result files");
  AddCommonOptions(replay, &arguments);
  replay
      ->add_option("SEQUENCE", arguments.replay.sequence,
                   "EuRoC ASL folder, KITTI odometry folder or LCM log")
      ->required();
  replay->add_option("--output", arguments.replay.output, "Folder for the result files")->required();
  replay
      ->add_option("--calibration", arguments.replay.calibration,
                   "Calibration files of any tool or device to use instead of the sequence's own: "
                   "left.yaml,right.yaml")
      ->delimiter(',')
      ->allow_extra_args(false);
  replay->add_flag("--overwrite", arguments.replay.overwrite,
                   "Replace the results of an earlier run in that folder");
  replay
      ->add_option("--threads", arguments.replay.num_threads, "Threads that may be used; the map is the same")
      ->check(CLI::Range(1, 256));
  replay->add_flag("--realtime", arguments.replay.realtime,
                   "Hand frames over at their recorded times; the newest wins, as live");
  replay->add_option("--publish", arguments.replay.publish_url,
                     "LCM provider URL to publish pose, terrain, status on");
  replay->add_option("--save-map", arguments.replay.save_map,
                     "Write the map at the end into this .terrace file, for --load-map");
  replay
      ->add_option("--save-disparity", arguments.replay.save_disparity_every,
                   "Write the disparity of frames 0, N, 2N, ...")
      ->check(CLI::Range(1, 1'000'000));
  replay
      ->add_option("--save-tracks", arguments.replay.num_track_pictures,
                   "Write the tracked landmarks of N frames spread over the run, with their images, for the "
                   "report of terrace evaluate")
      ->check(CLI::Range(1, 100));

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUse;
  }

  CatchInterrupts();
  OutliveReaders();
  try {
    if (!arguments.log_file.empty()) LogToFile(arguments.log_file);
    std::vector<std::string> settings = arguments.settings;
    settings.insert(settings.end(), arguments.map_settings.begin(), arguments.map_settings.end());
    const Config config = LoadConfig(arguments.config_file, settings);
    if (arguments.print_config) {
      std::fputs(PrintConfig(config).c_str(), stdout);
    } else if (replay->parsed()) {
      RunReplay(arguments.replay, config);
    } else {
      RunLive(arguments.live, config);
    }
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kWrongUse;
  } catch (const OutputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kWrongUse;
  } catch (const SequenceError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kFailed;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return kFailed;
  }
  return kDone;
}

}  // namespace
}  // namespace terrace

int main(int argc, char** argv) {
  terrace::OccupyStandardStreams();
  // Standard output belongs to what was asked for; everything about the run goes to standard error.
  terrace::LogToStandardError();
  const int code = terrace::Run(argc, argv);
  if (terrace::StandardOutputIsWritten() || code != 0) return code;
  std::fprintf(stderr, "terraced: standard output cannot be written\n");
  return terrace::kFailed;
}
