// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "evaluation/evaluation.h"

namespace terrace {

/// The file report.html: one page with every plot inside, readable without a network.
/// @param view  file name beside it of a page to look around in; empty: there is none
std::string ToReport(const Evaluation& evaluation, const std::string& view = "");

}  // namespace terrace
