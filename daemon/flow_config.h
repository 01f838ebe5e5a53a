// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace terrace {

/// How the stages work together. YAML section: `pipeline`.
struct FlowConfig {
  /// What a later stage learns from a frame reaches the earlier stages this many frames later, in every mode,
  /// so that the map does not depend on the number of threads.
  int feedback_lag_frames = 2;

  /// One sentence per problem; empty when the settings can be used.
  std::vector<std::string> Problems() const;
};

}  // namespace terrace
