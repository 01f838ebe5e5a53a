// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/synthetic/faulty_recording.h"

namespace terrace::synthetic {

/// No fault has this name, or it cannot happen to this recording.
class FaultError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// When a fault happens, in images: what lasts for a while begins at `begin` and ends before `end`; what
/// begins and stays begins at `begin`.
struct FaultSpan {
  std::size_t begin = 0;
  std::size_t end = 0;
  Timestamp t_begin, t_end;

  bool Holds(std::size_t image) const { return image >= begin && image < end; }
  bool Holds(Timestamp t) const { return t >= t_begin && t < t_end; }
  /// Two seconds after the start for two seconds; of a shorter recording the middle third.
  static FaultSpan Of(const FaultyRecording& recording);
};

/// Something that goes wrong on robots.
struct Fault {
  std::string name;
  std::string what;       ///< for people: what happens, with the unit of the strength
  double strength = 1.0;  ///< unless another is given
  std::function<void(FaultyRecording&, const FaultSpan&, double strength)> apply;
};

// By kind; README.md has the table.
std::vector<Fault> ImageFaults();
std::vector<Fault> PairFaults();
std::vector<Fault> TimeFaults();
std::vector<Fault> ImuFaults();
std::vector<Fault> PriorFaults();
/// All of these.
std::vector<Fault> AllFaults();

/// Damages a recording. @param description  NAME or NAME:strength. Throws FaultError, FileError.
void ApplyFault(const std::string& description, FaultyRecording& recording);

}  // namespace terrace::synthetic
