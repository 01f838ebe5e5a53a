// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace terrace {

/// A file cannot be read or does not hold what it should. what() is one sentence with the file, the place and
/// the rule.
class FileError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The bytes of a regular file of at most `max_bytes`. Throws FileError when it is missing, no file (a
/// folder, a device), larger or unreadable.
std::vector<std::uint8_t> ReadFileBytes(const std::filesystem::path& path,
                                        std::uintmax_t max_bytes = 1ull << 30);
std::string ReadTextFile(const std::filesystem::path& path, std::uintmax_t max_bytes = 1ull << 30);

/// Throws FileError when the file cannot be written to its end.
void WriteFileBytes(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

}  // namespace terrace
