// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/state_log.h"

#include <utility>

#include "core/print.h"

namespace terrace {

std::string RemedyFor(ReasonCode reason) {
  switch (reason) {
    case ReasonCode::kUnreadableImages:
      return "look at what the camera sends: terrace doctor";
    case ReasonCode::kFewFeatures:
      return "light, lens cap, exposure and blur: terrace doctor measures them";
    case ReasonCode::kNotFoundAgain:
      return "move back to where the map is; or give an IMU or leg odometry, which bridge longer";
    case ReasonCode::kAmbiguousMotion:
      return "the view repeats itself or moves as a whole: give an IMU or leg odometry, mask the robot's own "
             "body";
    case ReasonCode::kNoImages:
      return "start the camera (terrace camera); its channel is channels.images; terrace doctor checks the "
             "network";
    case ReasonCode::kNoCalibration:
    case ReasonCode::kBadCalibration:
      return "terrace calibration FILE... --output rig.yaml, then lcm.calibration: rig.yaml";
    case ReasonCode::kInputTrouble:
      return "the receive buffer, the camera's rate or the processor: terrace doctor checks them";
    case ReasonCode::kNone:
    case ReasonCode::kOther:
      break;
  }
  return "";
}

std::optional<StateLog::Line> StateLog::Add(const Status& status) {
  const Seen seen{status.state, status.tracking, status.reason_code};
  const std::int64_t num_lost = status.num_lost - std::exchange(num_lost_, status.num_lost);
  const bool new_world = std::exchange(epoch_, status.epoch) != status.epoch;
  // Lost and found again between two statuses is worth a line, too.
  const bool lost_meanwhile = num_lost > 0 && last_ && last_->tracking != TrackingStatus::kLost;
  if (std::exchange(last_, seen) == seen && !new_world && !lost_meanwhile) return std::nullopt;
  Line line;
  line.is_trouble = status.state != DaemonState::kRunning && status.state != DaemonState::kStarting &&
                    status.state != DaemonState::kPaused && status.state != DaemonState::kStopping;
  line.text = Printed("%s, %s", Name(status.state), Name(status.tracking));
  if (num_lost > 0) line.text += Printed(", lost for %lld frames", static_cast<long long>(num_lost));
  if (new_world) line.text += Printed(", another world begins (epoch %d)", status.epoch);
  if (!status.reason.empty()) line.text += ": " + status.reason;
  const std::string remedy = RemedyFor(status.reason_code);
  if (line.is_trouble && !remedy.empty()) line.text += "; " + remedy;
  return line;
}

}  // namespace terrace
