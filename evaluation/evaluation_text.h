// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "evaluation/evaluation.h"

namespace terrace {

/// The file evaluation.json: every number of README.md by name. Numbers that could not be measured are null.
std::string ToJson(const Evaluation& evaluation);

/// The same of a single disparity image.
std::string ToJson(const DisparityErrors& errors);

/// What a person wants to see first, as lines of text.
std::string ToTable(const Evaluation& evaluation);
std::string ToTable(const DisparityErrors& errors);

}  // namespace terrace
