// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace terrace {

/// From now on SIGINT, SIGTERM and SIGHUP only set a flag, so that results are written before the end; a
/// second signal ends the process at once. Nor does a broken pipe end it.
void CatchInterrupts();

/// True once a signal has come.
bool Interrupted();

}  // namespace terrace
