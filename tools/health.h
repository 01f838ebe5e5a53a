// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/status.h"
#include "tools/finding.h"

namespace terrace {

/// What a daemon's status says about its health: only what is not as it should be, worst first. Healthy is
/// what has no trouble among it.
/// @param before  an earlier status of the same daemon, against which counts are compared; null: what has
/// happened
///                since the daemon began is a note, not a trouble
std::vector<Finding> JudgeStatus(const Status& status, const Status* before);

/// Some lines for people: state, rates, inputs, stages, findings.
std::string StatusPage(const Status& status, const std::vector<Finding>& findings);

/// All of it for programs: one line of JSON, members as in status_v1_t, with "healthy" and "findings" beside
/// them.
std::string StatusJson(const Status& status, const std::vector<Finding>& findings);

}  // namespace terrace
