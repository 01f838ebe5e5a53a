// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "core/body_pose.h"
#include "core/time.h"

namespace terrace {

/// The newest poses of the body, in order of capture.
class PoseHistory {
 public:
  /// Poses may come late or twice. A new epoch forgets the old one's: they have no common frame.
  void Add(const BodyPose& pose);

  /// The newest one, whatever its status; none before the first.
  std::optional<BodyPose> newest() const;

  /// Where the body was: between the poses before and after, straight and at an even turn, with the larger
  /// covariance of the two and the worse status. None: before the oldest, after the newest, while lost, or
  /// between two that are further apart than 0.5 s.
  std::optional<BodyPose> At(Timestamp t) const;

 private:
  std::deque<BodyPose> poses_;  // ascending by t_capture, all of one epoch
};

}  // namespace terrace
