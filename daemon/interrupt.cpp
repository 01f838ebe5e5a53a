// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/interrupt.h"

#include <csignal>

namespace terrace {
namespace {

volatile std::sig_atomic_t interrupted = 0;

void OnSignal(int signal) {
  interrupted = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void CatchInterrupts() {
  struct sigaction action {};
  action.sa_handler = OnSignal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);
}

void OutliveReaders() { std::signal(SIGPIPE, SIG_IGN); }

bool Interrupted() { return interrupted != 0; }

}  // namespace terrace
