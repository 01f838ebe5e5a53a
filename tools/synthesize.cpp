// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "core/file_bytes.h"
#include "datasets/synthetic/family.h"
#include "datasets/synthetic/fault.h"
#include "datasets/synthetic/scene_file.h"
#include "datasets/synthetic/synthesis.h"
#include "tools/commands.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string scene;
  std::string out;
  std::string motion;
  synthetic::SynthesisConfig config;
  bool overwrite = false;
  std::string fault;
  bool list_faults = false;
};

/// Makes the folder ready: absent or empty, or rid of what an earlier run left.
void PrepareFolder(const fs::path& out, bool overwrite) {
  if (fs::exists(out) && !fs::is_directory(out)) throw UsageError(out.string() + " is not a folder");
  if (fs::exists(out) && !fs::is_empty(out)) {
    if (!overwrite) throw UsageError(out.string() + " is not empty; --overwrite replaces what is there");
    for (const char* name : {"mav0", "depth", "labels", "README.md", "calibration.yaml",
                             "groundtruth_tum.txt", "ground_truth.json", "observed_cells.npz"}) {
      fs::remove_all(out / name);
    }
  }
  fs::create_directories(out);
}

void ShowProgress(int done, int of) {
  if (isatty(STDERR_FILENO) != 0) {
    std::fprintf(stderr, "\rsynthesize: frame %d of %d%s", done, of, done == of ? "\n" : "");
  } else if (done == of || done % 50 == 0) {
    std::fprintf(stderr, "synthesize: frame %d of %d\n", done, of);
  }
}

/// A file, a shipped scene, or `family:NAME`, a place drawn by the seed.
synthetic::Scene SceneOf(const Options& options) {
  constexpr std::string_view kFamilyPrefix = "family:";
  try {
    if (options.scene.starts_with(kFamilyPrefix))
      return synthetic::DrawPlace(options.scene.substr(kFamilyPrefix.size()), options.config.seed);
    return synthetic::LoadScene(synthetic::FindScene(options.scene));
  } catch (const synthetic::SceneError& error) {
    throw UsageError(error.what());
  }
}

bool IsRecording(const fs::path& path) { return fs::is_directory(path / "mav0"); }

void PrintFaults() {
  for (const synthetic::Fault& fault : synthetic::AllFaults())
    std::printf("%-22s %8g  %s\n", fault.name.c_str(), fault.strength, fault.what.c_str());
}

/// A copy of a recording in which something goes wrong.
void Damage(const Options& options, const fs::path& source) {
  if (!IsRecording(source)) throw UsageError(source.string() + " is no EuRoC folder");
  if (fs::exists(options.out) && fs::equivalent(source, options.out))
    throw UsageError("OUT must be another folder than the recording");
  try {
    synthetic::FaultyRecording recording = synthetic::ReadRecording(source);
    const auto num_frames = static_cast<std::size_t>(options.config.max_frames);
    if (num_frames > 0 && num_frames < recording.left.size())
      recording.EndAt(recording.left[num_frames - 1].t);
    synthetic::ApplyFault(options.fault, recording);
    PrepareFolder(options.out, options.overwrite);
    synthetic::WriteRecording(recording, options.out);
  } catch (const synthetic::FaultError& error) {
    throw UsageError(error.what());
  }
  std::printf("%s: %s with %s\n", options.out.c_str(), source.c_str(), options.fault.c_str());
}

void Render(const Options& options, const fs::path& out) {
  synthetic::Scene scene = SceneOf(options);
  if (!options.motion.empty()) {
    scene.motion.kind = *synthetic::MotionKindFromName(options.motion);
    scene.motion.duration_s = 0.0;  // that of the scene belongs to its own motion
  }
  std::string problems;
  for (const std::string& problem : options.config.Problems())
    problems += (problems.empty() ? "" : "\n") + problem;
  if (!problems.empty()) throw UsageError(problems);
  PrepareFolder(out, options.overwrite);
  const synthetic::SynthesisSummary summary = synthetic::Synthesize(scene, options.config, out, ShowProgress);
  std::printf(
      "%s: %d stereo frames over %.2f m in %.1f s (light %.1f s, images %.1f pairs/s, %.1f million rays/s)\n",
      out.c_str(), summary.num_frames, summary.path_length_m, summary.total_s, summary.bake_s,
      summary.num_frames / summary.render_s, static_cast<double>(summary.num_rays) / summary.render_s * 1e-6);
}

void Run(const Options& options) {
  if (options.list_faults) return PrintFaults();
  if (options.scene.empty() || options.out.empty()) throw UsageError("SCENE and OUT must be given");
  if (IsRecording(options.scene) && options.fault.empty())
    throw UsageError(options.scene + " is a recording: say with --fault what goes wrong in its copy");
  if (options.fault.empty()) return Render(options, options.out);
  if (IsRecording(options.scene)) return Damage(options, options.scene);
  const fs::path undamaged = fs::path(options.out + ".undamaged");
  Render(options, undamaged);
  Damage(options, undamaged);
  fs::remove_all(undamaged);
}

}  // namespace

void AddSynthesizeCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "synthesize", "Render a stereo sequence of a known world, with exact truth, as an EuRoC folder");
  auto options = std::make_shared<Options>();
  synthetic::SynthesisConfig& config = options->config;
  command->add_option(
      "SCENE", options->scene,
      "name of a shipped scene, a YAML file, or family:NAME, a place drawn at random by the seed; with "
      "--fault also a recording (EuRoC folder)");
  command->add_option("OUT", options->out, "folder to write");
  command->add_option("--fault", options->fault, "NAME or NAME:STRENGTH: what goes wrong (--list-faults)");
  command->add_flag("--list-faults", options->list_faults, "print every fault with its strength, and end");
  command->add_option("--seed", config.seed, "of noise, gait and sensors, and of a family's place")
      ->capture_default_str();
  command->add_option("--frames", config.max_frames, "at most so many; 0: as long as the motion lasts");
  command->add_option("--rate", config.rate_hz, "stereo frames a second; 0: the scene's");
  command->add_option("--motion", options->motion, "instead of the scene's")
      ->check(CLI::IsMember({"walk", "stand", "creep", "turn_on_spot"}));
  command->add_option("--threads", config.renderer.num_threads,
                      "0: all processors; the bytes do not depend on it");
  command->add_option("--samples", config.renderer.samples, "samples a pixel, a power of two")
      ->capture_default_str();
  command
      ->add_option("--truth-every", config.truth_every, "depth and labels of every so manyth frame; 0: none")
      ->capture_default_str();
  command->add_option("--gain", config.gain, "times the brightness; below 1: dark and noisy")
      ->capture_default_str();
  command->add_flag("--overwrite", options->overwrite, "replace the sequence that OUT holds");
  command->callback([options] { Run(*options); });
}

}  // namespace terrace
