// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/sequence.h"

namespace terrace {

/// One frame of a folder of images, before its images are decoded.
struct FolderFrame {
  Timestamp t_capture;
  std::filesystem::path left;
  std::filesystem::path right;
  std::string problem;  ///< known before decoding, such as a missing partner
};

/// Throws SequenceError with all problems, a line each, when there are any.
void ThrowIfAny(const std::vector<std::string>& problems);

/// Plays frames of image files together with the samples that were read before. What the readers of folders
/// share.
class FolderSequence : public Sequence {
 public:
  /// Frames and samples must rise in time. Throws SequenceError when no image has the calibrated size.
  FolderSequence(SequenceInfo info, std::vector<FolderFrame> frames, SensorSamples samples,
                 std::int64_t num_time_jumps);

  const SequenceInfo& info() const override { return info_; }
  std::optional<SensorFrame> Next() override;
  std::int64_t num_time_jumps() const override { return num_time_jumps_; }

 private:
  StereoPair LoadPair(const FolderFrame& frame) const;
  SensorSamples TakeSamplesUpTo(Timestamp t);
  void CheckImageSizes() const;

  SequenceInfo info_;
  std::vector<FolderFrame> frames_;
  SensorSamples samples_;
  std::int64_t num_time_jumps_;
  std::size_t next_frame_ = 0;
  std::size_t next_imu_ = 0;
  std::size_t next_prior_ = 0;
};

}  // namespace terrace
