// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_record.h"

#include <nlohmann/json.hpp>

namespace terrace {
namespace {

template <typename Integer>
void AppendLittleEndian(Integer value, std::string* bytes) {
  for (std::size_t i = 0; i < sizeof(Integer); ++i) {
    bytes->push_back(static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xff));
  }
}

}  // namespace

ViewBytes MakeViewRecord(ViewRecordKind kind, Timestamp t, Timestamp t_heard, const void* content,
                         std::size_t size) {
  constexpr std::size_t kHeaderBytes = 20;
  auto bytes = std::make_shared<std::string>();
  bytes->reserve(kHeaderBytes + size);
  bytes->push_back(static_cast<char>(kind));
  bytes->append(3, '\0');
  AppendLittleEndian(t.utime(), bytes.get());
  AppendLittleEndian(t_heard.utime(), bytes.get());
  bytes->append(static_cast<const char*>(content), size);
  return bytes;
}

ViewBytes MakeViewRecord(ViewRecordKind kind, Timestamp t, const std::string& content) {
  return MakeViewRecord(kind, t, {}, content.data(), content.size());
}

std::string ViewRecording(std::span<const ViewBytes> records) {
  std::string recording = "TERRACE1";
  for (const ViewBytes& record : records) {
    AppendLittleEndian(static_cast<std::uint32_t>(record->size()), &recording);
    recording += *record;
  }
  return recording;
}

ViewBytes MakeHello(const ViewHello& hello) {
  const nlohmann::json json = {{"source", hello.source},
                               {"name", hello.name},
                               {"version", TERRACE_VERSION},
                               {"control", hello.control}};
  // Names of files may hold bytes that are no text.
  return MakeViewRecord(ViewRecordKind::kHello, {},
                        json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace terrace
