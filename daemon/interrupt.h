// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace terrace {

/// From now on SIGINT, SIGTERM and SIGHUP only set a flag, so that what is at hand is brought to its end; a
/// second signal ends the process at once.
void CatchInterrupts();

/// From now on it does not end the process that whoever reads its output has gone: what cannot be written is
/// told at the end.
void OutliveReaders();

/// True once a signal has come.
bool Interrupted();

}  // namespace terrace
