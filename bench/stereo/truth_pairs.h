// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/camera.h"
#include "datasets/ground_truth.h"
#include "evaluation/disparity_truth.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// A rectified pair with true disparities.
struct TruthPair {
  std::string name;
  StereoFrame frame;
  int max_disparity_px = 64;
  RenderedTruth truth;                                             ///< without labels when it is not rendered
  Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();  ///< of rendered pairs
};

struct TruthSet {
  std::string name;
  std::vector<TruthPair> pairs;
  TrueScene scene;      ///< of rendered sets, else empty
  StereoCamera camera;  ///< of rendered sets

  bool rendered() const { return !scene.polygons.empty(); }
};

/// `data` is the folder that TERRACE_DATA names.
TruthSet ReadMiddleburyV3(const std::filesystem::path& data);
TruthSet ReadMiddlebury2001To2003(const std::filesystem::path& data);

/// The same pairs with what many rigs have done to the right image: half the exposure and a little gain, a
/// vignette, blur, rows off by 0.3 px, and noise of its own.
TruthSet WithDamagedRight(TruthSet set);

/// Every `stride`-th frame of a rendered sequence that has a depth image. What is nearer than the search of
/// 128 px goes is blindness, not error: it counts nowhere.
TruthSet ReadRendered(const std::string& name, const std::filesystem::path& sequence, int stride);

/// A walk frame by frame, with its true poses; what is true of the images is known of some.
struct Walk {
  struct Frame {
    StereoFrame frame;
    Eigen::Isometry3d T_world_left = Eigen::Isometry3d::Identity();
    std::optional<RenderedTruth> truth;
  };
  std::vector<Frame> frames;
  StereoCamera camera;
};
Walk ReadWalk(const std::filesystem::path& sequence);

/// A scene of the synthetic world, rendered into a temporary folder that is gone afterwards.
/// @param rate_hz  low: few frames from all over the walk
TruthSet RenderScene(const std::string& scene, double gain, double rate_hz, int max_frames);

}  // namespace terrace
