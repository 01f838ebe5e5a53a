// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/explanation.h"

namespace terrace {

/// What keeps a region undecided by this rule, as it is published; empty: the rule decides.
const char* WhyUndecided(LabelRule rule);

}  // namespace terrace
