// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "odometry/landmark_tracker.h"
#include "odometry/window.h"

namespace terrace {

/// Notices a pair whose images are not of one moment. While the camera moves, what the later image shows has
/// moved on: a landmark lies higher or lower in it, by another amount from frame to frame. A calibration that
/// is wrong shifts a landmark by the same in every frame.
class RowChanges {
 public:
  /// Takes in where a tracked frame found the window's landmarks.
  /// @return true when it has just become certain
  bool Update(const Window& window, const std::vector<Match>& matches);

  /// The two images are not of one moment.
  bool come_and_go() const { return num_left_ > 0; }
  /// How much rows change from one frame to the next, root mean square over the last ones [px].
  double change_px() const;

 private:
  struct Place {
    Eigen::Vector2d left_px = Eigen::Vector2d::Zero();
    double lower_px = 0.0;  ///< v in the right image less v in the left one
  };
  std::vector<std::pair<std::int64_t, Place>> before_;  // by landmark, ascending
  double squares_ = 0.0, weight_ = 0.0;   ///< of the changes, forgetting
  int num_left_ = 0;                      ///< frames in motion without it until it is over
};

}  // namespace terrace
