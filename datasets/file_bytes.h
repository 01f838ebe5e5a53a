// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace terrace {

/// The bytes of a regular file of at most `max_bytes`. When it is missing, no file, too large or unreadable:
/// nothing, and `problem` says so in one sentence that names the file.
std::vector<std::uint8_t> ReadFileBytes(const std::filesystem::path& path, std::uint64_t max_bytes,
                                        std::string* problem);

}  // namespace terrace
