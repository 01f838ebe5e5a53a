// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "core/pose_estimate.h"
#include "recording.h"

namespace terrace {

/// What the odometry made of a recording, and what that took.
struct Trial {
  std::vector<PoseEstimate> poses;  ///< one a frame
  std::vector<double> cpu_s;        ///< likewise
  double sgbm_cpu_s = 0.0;          ///< of OpenCV's matcher, a frame; 0: not asked for
  double heap_early_mib = 0.0;      ///< after a quarter of the frames
  double heap_mib = 0.0;
  Gravity gravity;
};

/// Everything measured about one run.
struct Outcome {
  int frames = 0;
  int tracked = 0;
  int bridging = 0;
  int lost = 0;
  double ate_mm = 0.0;
  double end_mm = 0.0;
  double max_jump_mm = 0.0;
  std::map<double, double> relative_percent;
  double mean_relative = 0.0;
  double nees = 0.0;
  double nees_rotation = 0.0;
  double nees_translation = 0.0;
  double nees_bridging = 0.0;  ///< of bridging frames alone
  double cpu_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
  double sgbm_ratio = 0.0;
  double heap_early_mib = 0.0;
  double heap_mib = 0.0;
  Gravity gravity;
  double gravity_error_deg = 0.0;
  double path_m = 0.0;
  int num_epochs = 1;
  double returned_mm = 0.0;         ///< how far the last pose is from the first
  double returned_in_sigmas = 0.0;  ///< the same, in its own sigmas
  std::size_t digest = 0;
};

/// Compares with the truth; only what needs none where that is of fewer than three frames.
Outcome Judge(const Trial& trial, const Recording& recording);

/// One text line a frame: pose, truth, error, sigmas. Frames that are lost, or without truth, are left out.
void WritePoses(const Trial& trial, const Recording& recording, const std::string& path);

}  // namespace terrace
