// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "evaluation/evaluation.h"
#include "tools/view_record.h"

namespace terrace {

/// What was true, moved into the world of the result: the surfaces that were asked for, and the way. Empty
/// where the sequence has no truth.
std::vector<ViewBytes> RecordsOfTruth(const Evaluation& evaluation);

/// How far the result is from it, in words.
std::vector<std::pair<std::string, std::string>> RowsOfTruth(const Evaluation& evaluation);

}  // namespace terrace
