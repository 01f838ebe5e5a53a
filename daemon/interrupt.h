// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace terrace {

/// From now on SIGINT and SIGTERM only set a flag, so that results are written before the end. A second
/// signal ends the process at once.
void CatchInterrupts();

/// True once a signal has come.
bool Interrupted();

}  // namespace terrace
