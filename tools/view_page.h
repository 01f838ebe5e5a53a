// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "tools/view_record.h"

namespace terrace {

/// The page that viewer/ makes: the given file, else the installed one beside this program, else the one that
/// was built beside it. Throws FileError (core/file_bytes.h) with how to get one.
std::string ReadViewPage(const std::filesystem::path& given = {});

/// The page with a recording inside: one file that needs no server.
std::string PageWithRecording(const std::string& page, std::span<const ViewBytes> records);

std::string Base64(const std::string& bytes);

}  // namespace terrace
