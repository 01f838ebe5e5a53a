// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <terrace/status_v1_t.hpp>

#include "core/status.h"

namespace terrace {

status_v1_t ToMessage(const Status& status);
std::optional<Status> FromMessage(const status_v1_t& message);

}  // namespace terrace
