// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/progress.h"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

namespace terrace {

Progress::Progress(std::int64_t num_total)
    : num_total_(std::max<std::int64_t>(num_total, 1)),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (drawn_) std::fputc('\n', stderr);
}

void Progress::Update(std::int64_t num_done, const std::string& note) {
  using namespace std::chrono_literals;
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate_hz = seconds > 0 ? static_cast<double>(num_done) / seconds : 0.0;
  const std::int64_t tenth = std::min(num_done, num_total_) * 10 / num_total_;
  if (terminal_) {
    if (drawn_ && now - last_drawn_ < 100ms && num_done < num_total_) return;
    last_drawn_ = now;
    drawn_ = true;
    const std::string bar = std::string(static_cast<std::size_t>(tenth) * 3, '#');
    std::fprintf(stderr, "\r[%-30s] %lld/%lld  %.1f frames/s  %-40.40s", bar.c_str(),
                 static_cast<long long>(num_done), static_cast<long long>(num_total_), rate_hz, note.c_str());
  } else if (tenth > last_tenth_) {
    last_tenth_ = tenth;
    std::fprintf(stderr, "%lld of %lld frames, %.1f frames/s, %s\n", static_cast<long long>(num_done),
                 static_cast<long long>(num_total_), rate_hz, note.c_str());
  }
}

}  // namespace terrace
