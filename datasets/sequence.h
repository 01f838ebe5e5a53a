// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/sensor_frame.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// A sequence cannot be used at all: missing, not recognised, without stereo, or with senseless calibration.
/// what() is one sentence a problem, each with the file and the rule.
class SequenceError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class SequenceKind { kEuroc, kKitti, kLcmLog };
const char* Name(SequenceKind kind);  ///< "EuRoC ASL folder", ...

/// What is known of a sequence before its first frame is read.
struct SequenceInfo {
  SequenceKind kind = SequenceKind::kEuroc;
  std::filesystem::path path;
  StereoCalibration calibration;
  std::int64_t num_frames = 0;  ///< stereo frames
  Timestamp t_first;
  Timestamp t_last;
  bool has_imu = false;
  bool has_attitude = false;
  bool has_legs = false;
  bool has_true_poses = false;
  /// What was strange but survivable while opening, a sentence each.
  std::vector<std::string> warnings;
};

/// Reads a recorded sequence frame by frame, in order of time.
class Sequence {
 public:
  virtual ~Sequence() = default;
  virtual const SequenceInfo& info() const = 0;
  /// The next frame with the samples up to it; none at the end. A frame that cannot be read comes with
  /// `pair.problem` set: it is reported, not skipped. Frames whose time does not rise are skipped and
  /// counted.
  virtual std::optional<SensorFrame> Next() = 0;
  /// Frames left out because their time did not rise, so far.
  virtual std::int64_t num_time_jumps() const = 0;
};

/// What `path` is, by a look at its folders or first bytes; none when it is no sequence.
std::optional<SequenceKind> RecogniseSequence(const std::filesystem::path& path);

/// Opens what `path` turns out to be: an EuRoC ASL folder, a KITTI odometry folder or an LCM log.
/// Throws SequenceError.
/// @param channels  on which a log carries what
std::unique_ptr<Sequence> OpenSequence(const std::filesystem::path& path, const ChannelConfig& channels = {});

}  // namespace terrace
