// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "evaluation/evaluation.h"

namespace terrace {

/// The file report.html: one page with every plot inside, readable without a network.
std::string ToReport(const Evaluation& evaluation);

}  // namespace terrace
