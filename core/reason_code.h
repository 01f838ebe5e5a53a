// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace terrace {

/// Why a pose, or the daemon, is not well: for programs, beside the sentence for people. The numbers are
/// those of pose_v1_t and status_v1_t and never change their meaning.
enum class ReasonCode : std::int16_t {
  kNone = 0,              ///< all is well
  kOther = 1,             ///< the sentence says it
  kUnreadableImages = 2,  ///< damaged, of the wrong size, or missing
  kFewFeatures = 3,       ///< dark, covered, blurred or bare
  kNotFoundAgain = 4,     ///< features enough, but none that is known
  kAmbiguousMotion = 5,   ///< another motion explains the images nearly as well
  kNoImages = 6,          ///< nothing arrives
  kNoCalibration = 7,
  kBadCalibration = 8,
  kInputTrouble = 9,  ///< inputs were lost, late, damaged or dropped
};
inline constexpr int kNumReasonCodes = 10;
const char* Name(ReasonCode code);  ///< "none", "few features", ...

}  // namespace terrace
