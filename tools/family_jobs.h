// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate_all.h"

namespace terrace {

/// The jobs of a line: one for each seed of `family:NAME,seeds=FIRST-LAST[,option=value]...` (or seeds=ONE),
/// named after the line and the seed; of any other line itself. Throws FileError, naming `where`.
std::vector<EvaluationJob> ExpandFamily(const EvaluationJob& line, const std::string& where);

/// The lines that ask for these families with the same seeds; the name `all` stands for all families. Throws
/// FileError when there is no such family.
std::vector<EvaluationJob> FamilyLines(const std::vector<std::string>& families, const std::string& seeds);

}  // namespace terrace
