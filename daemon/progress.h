// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace terrace {

/// Tells on standard error how far a replay is: a bar on a terminal, a line every tenth otherwise.
class Progress {
 public:
  explicit Progress(std::int64_t num_total);
  ~Progress();

  void Update(std::int64_t num_done, const std::string& note);

 private:
  const std::int64_t num_total_;
  const bool terminal_;
  const std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_drawn_;
  std::int64_t last_tenth_ = 0;
  bool drawn_ = false;
};

}  // namespace terrace
