// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace terrace {

/// To be called first: a standard stream that was closed by who started the program would otherwise be the
/// number of the first file that is opened, and what is printed would end up in it.
void OccupyStandardStreams();

/// Writes what is buffered for standard output; false when something could not be written since the start.
bool StandardOutputIsWritten();

}  // namespace terrace
