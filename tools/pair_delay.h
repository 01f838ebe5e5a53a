// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/time.h"
#include "stereo/row_alignment.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// A point in both images, and how it moves in the left one.
struct MovingRowMatch {
  RowMatch match;
  double row_velocity_px_s = 0.0;  ///< downwards; the mean from the frame before to the one after
};

/// Follows points of the middle one of three frames into the other two. Those that are not found in both are
/// left out.
std::vector<MovingRowMatch> FollowMatches(const std::vector<RowMatch>& matches, const StereoFrame& before,
                                          const StereoFrame& at, const StereoFrame& after);

/// By how much the right camera is late.
struct PairDelay {
  int num_matches = 0;
  double delay_s = 0.0;
  double fit_sigma_s = 0.0;     ///< how well points and rows tell it
  double sigma_s = 0.0;         ///< with what velocities are off by
  double row_speed_px_s = 0.0;  ///< what it was told by: mean of the points' |row_velocity_px_s|

  /// Whether the image moved enough up and down to tell.
  bool told() const;
};

/// In a late image everything is where it has moved on to: rows are off in proportion to how fast they move,
/// beside a shift, roll, stretch and leaning baseline that stay. Robust.
PairDelay EstimateDelay(const std::vector<MovingRowMatch>& matches, const StereoCamera& camera);

}  // namespace terrace
