// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/sensor_frame.h"
#include "tools/camera_config.h"
#include "tools/camera_frame.h"

namespace terrace {

/// Makes stereo pairs of what one or two devices send. What cannot be read becomes a pair with a problem, so
/// that the mapper knows of it.
class PairMaker {
 public:
  explicit PairMaker(const CameraConfig& config) : config_(config) {}

  /// @param device  0: the left one, or the one that sends both; 1: the right one
  /// @return  a pair that is complete with this frame
  std::optional<StereoPair> Add(int device, RawFrame frame);

  /// Frames of two devices that found no partner.
  std::int64_t num_unmatched() const { return num_unmatched_; }
  /// Frames that the drivers say they have lost.
  std::int64_t num_lost() const { return num_lost_; }

 private:
  std::optional<StereoPair> Match();
  Timestamp MiddleOfExposure(const RawFrame& frame) const;

  const CameraConfig config_;
  std::deque<RawFrame> waiting_[2];
  std::optional<std::uint32_t> last_sequence_[2];
  std::int64_t num_unmatched_ = 0;
  std::int64_t num_lost_ = 0;
};

/// The frame as one grey image (Y8I: twice as wide as a camera's, still byte by byte). Throws FileError when
/// its bytes are not of its size or format.
GrayImage ToGray(const RawFrame& frame);

}  // namespace terrace
