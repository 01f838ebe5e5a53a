// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ring_log.h"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <utility>

#include "core/file_bytes.h"
#include "core/print.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".lcmlog";

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileError(folder.string() + ": cannot be made: " + error.message());
}

}  // namespace

RingLog::RingLog(fs::path folder, RingLogConfig config)
    : folder_(std::move(folder)), config_(std::move(config)) {
  MakeFolder(folder_);
  for (const auto& entry : fs::directory_iterator(folder_)) {
    // Files are named by the time of their first event.
    const std::string stem = entry.path().stem().string();
    const bool ours = entry.is_regular_file() && entry.path().extension() == kEnding && stem.size() == 20 &&
                      stem.find_first_not_of("0123456789") == std::string::npos;
    if (ours)
      segments_.push_back({entry.path(), std::stoll(stem), static_cast<std::int64_t>(entry.file_size())});
  }
  std::sort(segments_.begin(), segments_.end(),
            [](const Segment& a, const Segment& b) { return a.utime_first < b.utime_first; });
}

void RingLog::Add(std::int64_t utime, const std::string& channel, std::span<const std::uint8_t> data) {
  // A clock that is set back must not end the ring.
  const bool full =
      writer_ && (utime < segments_.back().utime_first ||
                  1e-6 * static_cast<double>(utime - segments_.back().utime_first) >= config_.segment_s);
  if (full) Close();
  if (config_.repeated_channels.contains(channel)) repeated_[channel].assign(data.begin(), data.end());
  if (!writer_) Open(utime);
  writer_->Write(utime, channel, data);
  segments_.back().num_bytes += static_cast<std::int64_t>(data.size());
  utime_last_ = utime;
}

void RingLog::Open(std::int64_t utime) {
  ForgetTheOldest();
  const fs::path path = folder_ / (Printed("%020lld", static_cast<long long>(utime)) + kEnding);
  writer_.emplace(path);
  segments_.push_back({path, utime, 0});
  for (const auto& [channel, data] : repeated_) writer_->Write(utime, channel, data);
}

void RingLog::Close() {
  if (!writer_) return;
  std::optional<LcmEventWriter> writer = std::exchange(writer_, std::nullopt);
  try {
    writer->Close();
  } catch (const FileError&) {
    std::error_code ignored;
    fs::remove(segments_.back().path, ignored);
    segments_.pop_back();
    throw;
  }
}

void RingLog::ForgetTheOldest() {
  // What is at hand must cover the span also just after a file has been forgotten.
  const auto too_old = [&] {
    return segments_.size() > 1 &&
           1e-6 * static_cast<double>(utime_last_ - segments_[1].utime_first) >= config_.span_s;
  };
  while (!segments_.empty() && (too_old() || num_bytes() > config_.max_bytes)) {
    std::error_code ignored;
    fs::remove(segments_.front().path, ignored);
    segments_.pop_front();
  }
}

std::vector<fs::path> RingLog::Take(const std::string& name) {
  Close();
  const fs::path folder = folder_ / name;
  MakeFolder(folder);
  std::vector<fs::path> taken;
  for (const Segment& segment : segments_) {
    std::error_code error;
    fs::rename(segment.path, folder / segment.path.filename(), error);
    if (!error) taken.push_back(folder / segment.path.filename());
  }
  segments_.clear();
  return taken;
}

std::int64_t RingLog::num_bytes() const {
  std::int64_t sum = 0;
  for (const Segment& segment : segments_) sum += segment.num_bytes;
  return sum;
}

double RingLog::span_s() const {
  return segments_.empty() ? 0.0 : 1e-6 * static_cast<double>(utime_last_ - segments_.front().utime_first);
}

void JoinLogs(const std::vector<fs::path>& parts, const fs::path& path) {
  const fs::path partial = path.string() + ".partial";
  {
    std::ofstream out(partial, std::ios::binary | std::ios::trunc);
    for (const fs::path& part : parts) {
      std::ifstream in(part, std::ios::binary);
      if (in.peek() != std::ifstream::traits_type::eof()) out << in.rdbuf();
    }
    out.close();
    if (!out) throw FileError(partial.string() + ": cannot be written to its end; the parts stay");
  }
  fs::rename(partial, path);
  std::error_code ignored;
  for (const fs::path& part : parts) fs::remove(part, ignored);
  if (!parts.empty()) fs::remove(parts.front().parent_path(), ignored);
}

}  // namespace terrace
