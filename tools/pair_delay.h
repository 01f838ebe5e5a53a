// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/time.h"
#include "stereo/row_alignment.h"
#include "stereo/stereo_frame.h"

namespace terrace {

/// A point in both images of a frame, and where it was and will be in the left one, two frames to either
/// side.
struct MovingRowMatch {
  static constexpr int kNumFrames = 5;

  RowMatch match;
  std::array<double, kNumFrames>
      t_s{};  ///< less the time of the frame in the middle, which is that of the match
  std::array<double, kNumFrames> row_px{};  ///< less the row in that frame

  /// How far down it has gone a time after the match: a curve of the fourth degree through all five rows, or
  /// of the second through the three in the middle.
  double RowAfter(double t_s, int degree = kNumFrames - 1) const;
};

/// Follows points of the frame in the middle into the others. Those that are not found in all are left out.
std::vector<MovingRowMatch> FollowMatches(
    const std::vector<RowMatch>& matches,
    const std::array<const StereoFrame*, MovingRowMatch::kNumFrames>& frames);

/// By how much the right camera is late.
struct PairDelay {
  int num_matches = 0;
  double delay_s = 0.0;
  double fit_sigma_s = 0.0;     ///< how well points and rows tell it
  double sigma_s = 0.0;         ///< with what the motion between frames is not known by
  double row_speed_px_s = 0.0;  ///< what it was told by: mean of the points' speed, up or down

  /// Whether the image moved enough up and down to tell.
  bool told() const;
};

/// In a late image everything is where it has moved on to: rows are off by how far they have moved since,
/// beside a shift, roll, stretch and leaning baseline that stay. Robust.
PairDelay EstimateDelay(const std::vector<MovingRowMatch>& matches, const StereoCamera& camera);

/// As they would be had the right camera not been late.
std::vector<RowMatch> WithoutDelay(const std::vector<MovingRowMatch>& matches, double delay_s);

}  // namespace terrace
