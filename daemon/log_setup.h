// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace terrace {

/// Where the daemon's log goes: to standard error, for a terminal with the time of day; for systemd's
/// journal, which has times of its own, with the level as the journal reads it.
void LogToStandardError();

/// Into a file as well, which is set aside when it has 10 MB; five of them are kept. Throws spdlog::spdlog_ex
/// when it cannot be written.
void LogToFile(const std::string& path);

}  // namespace terrace
