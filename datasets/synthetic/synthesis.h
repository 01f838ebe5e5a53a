// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/synthetic/renderer.h"
#include "datasets/synthetic/scene.h"
#include "datasets/synthetic/trajectory.h"

namespace terrace::synthetic {

struct SynthesisConfig {
  RendererConfig renderer;
  /// Of noise, gait and sensors; the scene itself has a seed of its own.
  std::uint32_t seed = 1;
  /// At most so many frames; 0: as many as the motion lasts.
  int max_frames = 0;
  /// Stereo frames a second; 0: the scene's.
  double rate_hz = 0.0;
  /// Depth and label images for every so manyth frame; 0: none.
  int truth_every = 10;
  /// Times the brightness that auto-exposure aims at: below 1 the camera is in the dark, with noise to match.
  double gain = 1.0;

  std::vector<std::string> Problems() const;
};

struct SynthesisSummary {
  int num_frames = 0;
  double path_length_m = 0.0;
  std::int64_t num_rays = 0;  ///< for images
  double render_s = 0.0;      ///< wall time of all images, without baking the light
  double bake_s = 0.0;
  double total_s = 0.0;
};

/// The robot's motion through a scene. `rays` tells the height of the ground.
Trajectory PlanMotionIn(const Scene& scene, const RayScene& rays, std::uint32_t seed);

/// Renders a scene into an EuRoC ASL folder with exact truth (README.md lists the files). The folder must
/// exist and is not emptied. Throws FileError or ImageError when something cannot be written.
/// @param progress  told after every frame how many of how many are done
SynthesisSummary Synthesize(const Scene& scene, const SynthesisConfig& config,
                            const std::filesystem::path& folder,
                            const std::function<void(int done, int of)>& progress);

}  // namespace terrace::synthetic
