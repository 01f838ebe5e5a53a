// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/camera.h"
#include "odometry/feature_finder.h"
#include "odometry/image_pyramid.h"
#include "odometry/window.h"

namespace terrace {

/// A landmark found in the current frame.
struct Match {
  int landmark = 0;  ///< index into Window::landmarks
  StereoMeasurement measurement;
  Projection predicted;      ///< where it was expected
  /// In the right image, too, perhaps on a row where it cannot be.
  bool found_in_right = false;
  double vertical_px = 0.0;  ///< v in the right image less v in the left one
  double scale = 1.0;        ///< size here over size in the host
  int level = 0;             ///< of the pyramid on which it was found at last
};

/// How landmarks are looked for.
struct SearchOptions {
  int start_level = 1;    ///< of the pyramid: how far off the prediction may be
  int finest_level = 0;   ///< where the search ends
  int max_per_cell = 2;   ///< landmarks tried in one cell of the grid
  bool use_right = true;  ///< measure disparities, too
};

struct Matches {
  std::vector<Match> found;
  std::vector<int> tried;  ///< landmarks looked for, as indices into Window::landmarks
  /// Those of them that should be seen: what the last frame hid says nothing of this one.
  int num_expected = 0;
  double trust_expected = 0.0;  ///< sum over these

  void NoteTried(int index, const Landmark& landmark) {
    tried.push_back(index);
    if (landmark.missed_last) return;
    ++num_expected;
    trust_expected += landmark.trust();
  }
};

/// Looks for the window's landmarks in a new frame. Each is predicted from the pose expected and looked for
/// with the texture of its host keyframe, warped as its plane demands, so that errors do not add up from
/// frame to frame.
class LandmarkTracker {
 public:
  LandmarkTracker(const StereoCamera& camera, const FeatureGrid& grid);

  Matches Track(const Window& window, const ImagePyramid& left, const ImagePyramid& right,
                const Eigen::Isometry3d& T_world_left, double vertical_px,
                const SearchOptions& options) const;
  /// Looks everywhere within reach of the prediction for the landmarks known best, on one level of the
  /// pyramid: for when the prediction is worth little.
  Matches SearchWide(const Window& window, const ImagePyramid& left, const Eigen::Isometry3d& T_world_left,
                     double reach_px, int level) const;

 private:
  std::vector<Match> Candidates(const Window& window, const Eigen::Isometry3d& T_world_left,
                                int max_per_cell) const;
  /// Has the pixels fetched from memory that FindInLeft() will read in the landmark's keyframe.
  void Prefetch(const Window& window, const Match& match, const SearchOptions& options) const;
  bool FindInLeft(const Landmark& landmark, const ImagePyramid& host, const ImagePyramid& left,
                  const SearchOptions& options, Match& match) const;
  void FindInRight(const ImagePyramid& left, const ImagePyramid& right, double vertical_px,
                   Match& match) const;

  StereoCamera camera_;
  FeatureGrid grid_;
};

}  // namespace terrace
