// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "core/explanation.h"

namespace terrace {

/// The text of explanations.jsonl: a line for each region, then one for each staircase of the map at the end.
std::string ExplanationsText(const Explanations& explanations);
/// Throws FileError (core/file_bytes.h) with the file, the place and the rule that is broken.
Explanations ReadExplanationsFile(const std::filesystem::path& path);

}  // namespace terrace
