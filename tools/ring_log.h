// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "datasets/lcm_event_log.h"

namespace terrace {

struct RingLogConfig {
  double span_s = 300.0;    ///< that are at hand at any time
  double segment_s = 10.0;  ///< of one file of the ring: what is forgotten at once
  std::int64_t max_bytes = 20'000'000'000;
  /// The newest message of these begins each file, so that each can be replayed by itself.
  std::set<std::string> repeated_channels;
};

/// The last minutes of a bus, as LCM logs in a folder. What an earlier run left there belongs to it: the
/// minutes before a crash are worth most.
class RingLog {
 public:
  /// Makes the folder. Throws FileError.
  RingLog(std::filesystem::path folder, RingLogConfig config);

  /// Throws FileError when a file could not be written to its end; that file is gone then, the rest stays.
  void Add(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data);

  /// Takes everything out of the ring, into a folder of its own, oldest first; the ring begins anew. Throws
  /// FileError.
  std::vector<std::filesystem::path> Take(const std::string& name);

  std::int64_t num_bytes() const;
  /// From the oldest event to the newest [s].
  double span_s() const;

 private:
  struct Segment {
    std::filesystem::path path;
    std::int64_t utime_first = 0;
    std::int64_t num_bytes = 0;
  };

  void Open(std::int64_t utime);
  void Close();
  void ForgetTheOldest();

  const std::filesystem::path folder_;
  const RingLogConfig config_;
  std::deque<Segment> segments_;  // the last one is being written while `writer_` is there
  std::optional<LcmEventWriter> writer_;
  std::map<std::string, std::vector<std::uint8_t>> repeated_;
  std::int64_t utime_last_ = 0;
};

/// Appends logs to one another under the name `path`, which is there only once it is whole; the parts and
/// their folder are removed. Throws FileError.
void JoinLogs(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& path);

}  // namespace terrace
