// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "test/fuzz/fuzz_targets.h"

namespace terrace::fuzz {

/// Of this process, in memory where there is such a file system; gone with the process.
const std::filesystem::path& Folder();
/// A file of this name in it; the name may hold folders.
std::filesystem::path Written(const std::string& name, Bytes bytes);

}  // namespace terrace::fuzz
