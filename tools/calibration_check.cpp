// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration_check.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

namespace terrace {
namespace {

/// Frames of a recording that are looked at.
constexpr std::int64_t kFramesToCheck = 20;
constexpr std::int64_t kInARow = MovingRowMatch::kNumFrames;

struct FrameAndMatches {
  StereoFrame frame;
  std::vector<RowMatch> matches;  // none where it is only a neighbour
};

/// The one in the middle of as many frames as it takes, without a gap.
std::vector<MovingRowMatch> Moving(const std::deque<FrameAndMatches>& row) {
  if (static_cast<std::int64_t>(row.size()) < kInARow ||
      row.back().frame.frame_id - row.front().frame.frame_id != kInARow - 1)
    return {};
  std::array<const StereoFrame*, MovingRowMatch::kNumFrames> frames{};
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = &row[i].frame;
  return FollowMatches(row[kInARow / 2].matches, frames);
}

}  // namespace

CalibrationCheck CheckCalibration(const Rectifier& rectifier, Sequence* sequence) {
  CalibrationCheck check;
  const std::int64_t every = std::max<std::int64_t>(1, sequence->info().num_frames / kFramesToCheck);
  const bool whole = every <= kInARow;  // a short recording
  RowMatchConfig config;
  config.max_disparity_px = rectifier.camera().width / 4;
  std::vector<MovingRowMatch> moving;
  std::deque<FrameAndMatches> row;
  while (const std::optional<SensorFrame> frame = sequence->Next()) {
    const std::int64_t place = frame->frame_id % every;
    if (!frame->pair.problem.empty() || (!whole && place >= kInARow)) continue;
    FrameAndMatches now{rectifier.Rectify(frame->frame_id, frame->pair), {}};
    if (place == (whole ? 0 : kInARow / 2)) {
      now.matches = MatchAcrossRows(now.frame, config);
      check.matches.insert(check.matches.end(), now.matches.begin(), now.matches.end());
      check.last_left = now.frame.left;
    }
    row.push_back(std::move(now));
    if (static_cast<std::int64_t>(row.size()) > kInARow) row.pop_front();
    const std::vector<MovingRowMatch> found = Moving(row);
    moving.insert(moving.end(), found.begin(), found.end());
  }
  const StereoCamera& camera = rectifier.camera();
  check.delay = EstimateDelay(moving, camera);
  check.rows_as_they_are = EstimateRowAlignment(check.matches, camera);
  check.rows = check.delay.told() ? EstimateRowAlignment(WithoutDelay(moving, check.delay.delay_s), camera)
                                  : check.rows_as_they_are;
  return check;
}

}  // namespace terrace
