// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/lcm_event_log.h"

#include <algorithm>
#include <array>

#include "core/file_bytes.h"

namespace terrace {
namespace {

// An event: sync word, event number, time of recording, length of the channel, length of the data; then both.
constexpr std::array<std::uint8_t, 4> kSyncWord = {0xed, 0xa1, 0xda, 0x01};
constexpr std::int64_t kHeaderBytes = 4 + 8 + 8 + 4 + 4;
constexpr std::int64_t kMaxChannelBytes = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH

std::int64_t BigEndian(const std::uint8_t* bytes, int size) {
  std::uint64_t value = 0;
  for (int i = 0; i < size; ++i) value = value << 8 | bytes[i];
  return size == 4 ? static_cast<std::int32_t>(value) : static_cast<std::int64_t>(value);
}

void AppendBigEndian(std::int64_t value, int size, std::vector<std::uint8_t>* out) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8) {
    out->push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> shift));
  }
}

}  // namespace

bool BeginsLikeLcmLog(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, kSyncWord.size()> head{};
  file.read(head.data(), head.size());
  return file && std::equal(kSyncWord.begin(), kSyncWord.end(), head.begin(),
                            [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); });
}

LcmEventReader::LcmEventReader(const std::filesystem::path& path) : in_(path, std::ios::binary) {
  std::error_code error;
  file_bytes_ = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (!in_ || error) throw FileError(path.string() + ": cannot be read");
}

bool LcmEventReader::Next(LcmEvent* event) {
  while (next_ < file_bytes_) {
    if (ReadEventAt(next_, event)) {
      next_ += kHeaderBytes + static_cast<std::int64_t>(event->channel.size() + event->data.size());
      return true;
    }
    const std::int64_t found = FindEventFrom(next_ + 1);
    num_skipped_bytes_ += found - next_;
    next_ = found;
  }
  return false;
}

void LcmEventReader::Seek(std::int64_t offset) { next_ = offset; }

bool LcmEventReader::ReadEventAt(std::int64_t offset, LcmEvent* event) {
  if (file_bytes_ - offset < kHeaderBytes) return false;
  std::array<std::uint8_t, kHeaderBytes> header;
  in_.clear();
  in_.seekg(offset);
  if (!in_.read(reinterpret_cast<char*>(header.data()), kHeaderBytes)) return false;
  const std::int64_t channel_bytes = BigEndian(header.data() + 20, 4);
  const std::int64_t data_bytes = BigEndian(header.data() + 24, 4);
  if (!std::equal(kSyncWord.begin(), kSyncWord.end(), header.begin()) || channel_bytes < 1 ||
      channel_bytes > kMaxChannelBytes || data_bytes < 0 ||
      channel_bytes + data_bytes > file_bytes_ - offset - kHeaderBytes) {
    return false;
  }
  event->offset = offset;
  event->utime = BigEndian(header.data() + 12, 8);
  event->channel.resize(static_cast<std::size_t>(channel_bytes));
  event->data.resize(static_cast<std::size_t>(data_bytes));
  in_.read(event->channel.data(), channel_bytes);
  in_.read(reinterpret_cast<char*>(event->data.data()), data_bytes);
  return static_cast<bool>(in_);
}

/// Where the next sync word is; the end of the file when there is none.
std::int64_t LcmEventReader::FindEventFrom(std::int64_t offset) {
  constexpr std::int64_t kChunkBytes = 1 << 16;
  std::vector<std::uint8_t> chunk;
  while (offset < file_bytes_) {
    chunk.resize(static_cast<std::size_t>(std::min(kChunkBytes, file_bytes_ - offset)));
    in_.clear();
    in_.seekg(offset);
    if (!in_.read(reinterpret_cast<char*>(chunk.data()), static_cast<std::streamsize>(chunk.size()))) break;
    const auto found = std::search(chunk.begin(), chunk.end(), kSyncWord.begin(), kSyncWord.end());
    if (found != chunk.end()) return offset + (found - chunk.begin());
    // The word may begin in the last three bytes.
    offset += std::max<std::int64_t>(1, static_cast<std::int64_t>(chunk.size()) - 3);
  }
  return file_bytes_;
}

LcmEventWriter::LcmEventWriter(const std::filesystem::path& path)
    : path_(path), out_(path, std::ios::binary) {
  if (!out_) throw FileError(path.string() + ": cannot be written");
}

void LcmEventWriter::Write(std::int64_t utime, const std::string& channel,
                           std::span<const std::uint8_t> data) {
  std::vector<std::uint8_t> header(kSyncWord.begin(), kSyncWord.end());
  AppendBigEndian(num_events_++, 8, &header);
  AppendBigEndian(utime, 8, &header);
  AppendBigEndian(static_cast<std::int64_t>(channel.size()), 4, &header);
  AppendBigEndian(static_cast<std::int64_t>(data.size()), 4, &header);
  out_.write(reinterpret_cast<const char*>(header.data()), static_cast<std::streamsize>(header.size()));
  out_.write(channel.data(), static_cast<std::streamsize>(channel.size()));
  out_.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
}

void LcmEventWriter::Close() {
  out_.close();
  if (!out_) throw FileError(path_.string() + ": cannot be written to its end");
}

}  // namespace terrace
