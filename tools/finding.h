// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

enum class Severity {
  kGood,     ///< as it should be
  kNote,     ///< works, could be better
  kTrouble,  ///< the map cannot be relied on
};
const char* Name(Severity severity);  ///< "good", "note", "trouble"

/// One thing that was looked at.
struct Finding {
  Severity severity = Severity::kGood;
  std::string code;    ///< for programs; never changes its meaning: "imu_silent"
  std::string text;    ///< what is, with the numbers
  std::string remedy;  ///< what to do; empty when nothing
};

bool AnyTrouble(const std::vector<Finding>& findings);
/// "trouble  imu_silent  no IMU for 3.2 s" and, below it, what to do.
std::string InWords(const Finding& finding);

}  // namespace terrace
