// SPDX-License-Identifier: BSD-3-Clause
#include "core/standard_streams.h"

#include <cerrno>
#include <cstdio>
#include <initializer_list>

#include <fcntl.h>
#include <unistd.h>

namespace terrace {

void OccupyStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is taken, which is this one. Writing to what is open for reading fails, as it
    // did before; complaints that nobody can read go nowhere.
    const int flags = stream == STDERR_FILENO ? O_WRONLY : O_RDONLY;
    if (open("/dev/null", flags) == -1) return;
  }
}

bool StandardOutputIsWritten() { return std::fflush(stdout) == 0 && std::ferror(stdout) == 0; }

}  // namespace terrace
