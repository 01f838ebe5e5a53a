// SPDX-License-Identifier: BSD-3-Clause
#include "bench/terrain/shots.h"

#include <cstddef>
#include <optional>

namespace terrace {

std::vector<Shot> ShootFrames(Sequence* sequence, Pipeline* pipeline, int num_frames) {
  std::vector<Shot> shots;
  FrameId frame_id = 0;
  while (static_cast<int>(shots.size()) < num_frames) {
    std::optional<SensorFrame> sensors = sequence->Next();
    if (!sensors) break;
    sensors->frame_id = frame_id++;
    const StereoFramePtr frame = pipeline->Rectify(*sensors);
    const auto disparity = pipeline->Match(frame);
    const TrackedPose tracked = pipeline->Track(*sensors, frame);
    pipeline->Map(nullptr, tracked);  // so that the odometry waits for no lesson
    if (tracked.pose.trusted && disparity) shots.push_back({disparity, tracked.pose, tracked.gravity});
  }
  return shots;
}

std::vector<Shot> OneIn(int stride, const std::vector<Shot>& shots) {
  std::vector<Shot> some;
  for (std::size_t i = 0; i < shots.size(); i += static_cast<std::size_t>(stride)) some.push_back(shots[i]);
  return some;
}

}  // namespace terrace
