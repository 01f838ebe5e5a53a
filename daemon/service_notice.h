// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/status.h"

namespace terrace {

/// Tells a service manager how the daemon is, as systemd's sd_notify(3) does: ready with the first map, a
/// status line, and a sign of life for its watchdog as long as what comes in goes through. Says nothing where
/// nobody asks (NOTIFY_SOCKET is not set).
class ServiceNotice {
 public:
  ServiceNotice();
  ~ServiceNotice();
  ServiceNotice(const ServiceNotice&) = delete;
  ServiceNotice& operator=(const ServiceNotice&) = delete;

  /// Once a second.
  void Tell(const Status& status);

 private:
  void Send(const std::string& text) const;

  int socket_ = -1;
  std::string address_;
  bool ready_ = false;
};

/// Whether frames come in and none comes out: what a watchdog should end.
bool IsStuck(const Status& status);

}  // namespace terrace
