// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terrace {

/// What a folder lacks to be a sequence of the kind that it comes nearest to, a sentence each; empty where
/// nothing is missing. For a folder that looks like none: what each kind must hold.
std::vector<std::string> FolderNeeds(const std::filesystem::path& folder);

}  // namespace terrace
