// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>
#include <terrace/footstep_plan_v1_t.hpp>

#include "core/file_bytes.h"
#include "lcmtypes/safe_decode.h"
#include "results/replay_result.h"
#include "tools/bus.h"
#include "tools/commands.h"
#include "tools/rectified_frames.h"
#include "tools/terrain_picture.h"

namespace terrace {
namespace {

struct DrawOptions {
  BusOptions channels;
  std::string result;
  std::string sequence;
  std::string picture;
  std::string map_picture;
  std::string footsteps;
  std::vector<std::filesystem::path> calibration;
  std::int64_t frame = -1;
  std::int64_t time_ns = -1;
};

void Save(const cv::Mat3b& picture, const std::string& path) {
  bool saved = false;
  try {
    saved = cv::imwrite(path, picture);
  } catch (const cv::Exception&) {  // an ending that is no image format
  }
  if (!saved) throw std::runtime_error(path + ": cannot be written as an image");
  std::printf("%s: %dx%d\n", path.c_str(), picture.cols, picture.rows);
}

/// The wanted frame of a sequence, rectified: by number, by time, or the last one that has a pose.
StereoFrame FindFrame(const DrawOptions& options, const StereoCamera& camera,
                      const std::vector<ResultPose>& trajectory) {
  const std::int64_t last_ns = trajectory.empty() ? 0 : trajectory.back().t_capture.ns;
  const std::int64_t wanted_ns = options.time_ns >= 0 ? options.time_ns : last_ns;
  std::optional<StereoFrame> found;
  ForRectifiedFrames(
      options.sequence, ConfigOf(options.channels).channels, options.calibration, camera,
      [&](const SensorFrame& frame) {
        return options.frame >= 0 ? frame.frame_id == options.frame : frame.pair.t_capture.ns == wanted_ns;
      },
      [&](const StereoFrame& frame) {
        found = frame;
        return false;
      });
  if (!found) throw std::runtime_error(options.sequence + ": has no such frame");
  return *found;
}

std::optional<footstep_plan_v1_t> PlanOf(const DrawOptions& options) {
  if (options.footsteps.empty()) return std::nullopt;
  constexpr std::uintmax_t kMaxBytes = std::uintmax_t{1} << 26;
  const std::vector<std::uint8_t> bytes = ReadFileBytes(options.footsteps, kMaxBytes);
  const auto plan = SafeDecode<footstep_plan_v1_t>(bytes.data(), bytes.size());
  if (!plan) throw std::runtime_error(options.footsteps + ": holds no footstep_plan_v1_t");
  return plan;
}

void DrawFrameOf(const DrawOptions& options, const footstep_plan_v1_t* plan) {
  const std::filesystem::path folder = options.result;
  const std::vector<ResultPose> trajectory = ReadTrajectoryFile(folder / "trajectory.tum");
  const ResultCamera camera = ReadCameraFile(folder / "camera.json");
  const StereoFrame frame = FindFrame(options, camera.camera, trajectory);
  const auto pose = std::find_if(trajectory.begin(), trajectory.end(),
                                 [&](const ResultPose& p) { return p.t_capture == frame.t_capture; });
  if (pose == trajectory.end()) throw std::runtime_error(options.result + ": that frame has no pose");
  const TerrainMap map = ReadTerrainMapFile(folder / "terrain_map.json");
  Save(DrawFrame(map, frame.left, camera.camera, pose->T_world_left, plan), options.picture);
}

void Draw(const DrawOptions& options) {
  const bool draw_frame = !options.sequence.empty() || !options.picture.empty();
  if (!draw_frame && options.map_picture.empty())
    throw UsageError("draw: give SEQUENCE and OUT.png, or --map OUT.png");
  if (draw_frame && options.picture.empty()) throw UsageError("draw: OUT.png is missing after SEQUENCE");
  const std::optional<footstep_plan_v1_t> plan = PlanOf(options);
  const footstep_plan_v1_t* const steps = plan ? &*plan : nullptr;
  if (!options.map_picture.empty())
    Save(DrawMap(ReadReplayResult(options.result), steps), options.map_picture);
  if (draw_frame) DrawFrameOf(options, steps);
}

}  // namespace

void AddDrawCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("draw", "Draw a replay's labelled regions over an image, or its map");
  auto options = std::make_shared<DrawOptions>();
  command->add_option("RESULT_DIR", options->result, "what terraced replay wrote")->required();
  command->add_option("SEQUENCE", options->sequence, "what it replayed");
  command->add_option("OUT.png", options->picture, "the rectified left image with the regions over it");
  command->add_option("--map", options->map_picture, "draw the whole map into this image");
  command->add_option("--footsteps", options->footsteps,
                      "a plan to draw on the ground: the bytes of a footstep_plan_v1_t, as terrace_footsteps "
                      "leaves them in PLAN.footsteps");
  AddChannelOptions(command, &options->channels);
  command->add_option("--calibration", options->calibration, "the files that the replay was given, if it was")
      ->delimiter(',')
      ->allow_extra_args(false);
  CLI::Option* frame =
      command->add_option("--frame", options->frame, "number of the frame, from 0; default: the last one");
  command->add_option("--time", options->time_ns, "capture time of the frame in nanoseconds")
      ->excludes(frame);
  command->callback([options] { Draw(*options); });
}

}  // namespace terrace
