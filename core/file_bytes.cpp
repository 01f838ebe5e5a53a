// SPDX-License-Identifier: BSD-3-Clause
#include "core/file_bytes.h"

#include <fstream>

namespace terrace {
namespace {

[[noreturn]] void Fail(const std::filesystem::path& path, const std::string& why) {
  throw FileError(path.string() + ": " + why);
}

template <typename Bytes>
Bytes ReadAll(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) Fail(path, "no such file");
  if (error) Fail(path, "cannot be read: " + error.message());
  if (!std::filesystem::is_regular_file(status)) Fail(path, "not a file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) Fail(path, "cannot be read: " + error.message());
  if (size > max_bytes) Fail(path, "larger than the " + std::to_string(max_bytes) + " bytes it may have");
  Bytes bytes(size, {});
  std::ifstream in(path, std::ios::binary);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!in) Fail(path, "cannot be read");
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> ReadFileBytes(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  return ReadAll<std::vector<std::uint8_t>>(path, max_bytes);
}

std::string ReadTextFile(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  return ReadAll<std::string>(path, max_bytes);
}

void WriteFileBytes(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) Fail(path, "cannot be written");
}

}  // namespace terrace
