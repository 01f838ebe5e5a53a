// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace terrace {

/// Whether the file begins with the word that begins every event of an LCM log.
bool BeginsLikeLcmLog(const std::filesystem::path& path);

/// One message in a log file.
struct LcmEvent {
  std::int64_t offset = 0;  ///< where it begins in the file
  std::int64_t utime = 0;   ///< when it was recorded [us]
  std::string channel;
  std::vector<std::uint8_t> data;
};

/// Reads the events of an LCM log. LCM's own reader trusts the lengths in the file; this one survives any
/// file: what is no event is skipped up to the next one, a cut last event ends the log.
class LcmEventReader {
 public:
  /// Throws FileError.
  explicit LcmEventReader(const std::filesystem::path& path);

  /// The next event; false at the end. Reuses the memory of `event`.
  bool Next(LcmEvent* event);
  /// Goes on with the event at this offset.
  void Seek(std::int64_t offset);

  /// Bytes passed over because they were no events, a cut end included.
  std::int64_t num_skipped_bytes() const { return num_skipped_bytes_; }
  std::int64_t file_bytes() const { return file_bytes_; }

 private:
  bool ReadEventAt(std::int64_t offset, LcmEvent* event);
  std::int64_t FindEventFrom(std::int64_t offset);

  std::ifstream in_;
  std::int64_t file_bytes_ = 0;
  std::int64_t next_ = 0;
  std::int64_t num_skipped_bytes_ = 0;
};

/// Writes an LCM log that every LCM tool can read.
class LcmEventWriter {
 public:
  /// Throws FileError when the file cannot be made.
  explicit LcmEventWriter(const std::filesystem::path& path);

  void Write(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data);
  /// Throws FileError when anything could not be written.
  void Close();

 private:
  std::filesystem::path path_;
  std::ofstream out_;
  std::int64_t num_events_ = 0;
};

}  // namespace terrace
