// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/file_bytes.h"

#include <fstream>

namespace terrace {

std::vector<std::uint8_t> ReadFileBytes(const std::filesystem::path& path, std::uint64_t max_bytes,
                                        std::string* problem) {
  problem->clear();
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    *problem = path.string() + ": no such file";
    return {};
  }
  if (!std::filesystem::is_regular_file(status)) {
    *problem = path.string() + ": not a file";
    return {};
  }
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error || size > max_bytes) {
    *problem = path.string() + ": " +
               (error ? error.message() : "larger than " + std::to_string(max_bytes) + " bytes");
    return {};
  }
  std::vector<std::uint8_t> bytes(size);
  std::ifstream in(path, std::ios::binary);
  if (!in || !in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    *problem = path.string() + ": cannot be read";
    return {};
  }
  return bytes;
}

}  // namespace terrace
