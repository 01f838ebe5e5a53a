// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "datasets/ground_truth.h"
#include "datasets/sequence.h"
#include "lcmtypes/channels.h"

namespace terrace {

/// Opens an LCM log with stereo pairs and their calibration, in the messages of lcmtypes/. Other channels and
/// types are passed over, and so is what is damaged: whatever is complete is used. Throws SequenceError; a
/// log without stereo is refused with one sentence that lists its channels.
std::unique_ptr<Sequence> OpenLcmLogSequence(const std::filesystem::path& path,
                                             const ChannelConfig& channels = {});

/// The true poses in a log: of the body, or of the raw left camera when the log knows no body; empty when
/// there are none. Throws FileError.
TrueTrajectory LoadLcmLogTruth(const std::filesystem::path& path, const ChannelConfig& channels = {});

/// What one channel of a log carries.
struct LcmLogChannel {
  std::string name;
  std::string type;    ///< the message's name when it is one of ours, else its fingerprint in hexadecimal
  bool known = false;  ///< one of ours
  std::uint64_t fingerprint = 0;  ///< of the type; 0 when a message is too short to have one
  std::int64_t utime_first = 0;   ///< when the first message was recorded [us]
  std::int64_t utime_last = 0;
  std::int64_t num_messages = 0;
  std::int64_t num_bytes = 0;
};

/// Every channel and type of any log, ours or not, by name. Throws FileError.
std::vector<LcmLogChannel> ListLcmLogChannels(const std::filesystem::path& path);

}  // namespace terrace
