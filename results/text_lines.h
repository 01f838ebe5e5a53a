// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace terrace {

/// Calls `use(line, place)` for every line of a file that is neither empty nor a comment; `place` is
/// "file:number". Throws FileError when the file cannot be read.
void ForEachLine(const std::filesystem::path& path,
                 const std::function<void(const std::string& line, const std::string& place)>& use);

}  // namespace terrace
