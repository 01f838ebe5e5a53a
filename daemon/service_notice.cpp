// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/service_notice.h"

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/print.h"

namespace terrace {

ServiceNotice::ServiceNotice() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  if (address == nullptr || (address[0] != '/' && address[0] != '@')) return;
  address_ = address;
  if (address_.size() >= sizeof(sockaddr_un::sun_path)) return;
  if (address_[0] == '@') address_[0] = '\0';  // Linux's abstract names begin with a zero
  socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
}

ServiceNotice::~ServiceNotice() {
  if (socket_ >= 0) close(socket_);
}

bool IsStuck(const Status& status) {
  const bool mapping = status.state == DaemonState::kRunning || status.state == DaemonState::kDegraded;
  return mapping && status.fps_in > 0.0 && status.fps_out <= 0.0;
}

void ServiceNotice::Tell(const Status& status) {
  if (socket_ < 0) return;
  std::string text = Printed("STATUS=%s, %s, %.1f of %.1f frames/s", Name(status.state),
                             Name(status.tracking), status.fps_out, status.fps_in);
  if (!status.reason.empty()) text += ": " + status.reason;
  for (char& c : text)
    if (c == '\n') c = ' ';
  const bool has_map = status.map_seq > 0;
  if (has_map && !ready_) {
    text += "\nREADY=1";
    ready_ = true;
  }
  if (!IsStuck(status)) text += "\nWATCHDOG=1";
  if (status.state == DaemonState::kStopping) text += "\nSTOPPING=1";
  Send(text);
}

void ServiceNotice::Send(const std::string& text) const {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  // A manager that does not listen is no reason to end.
  sendto(socket_, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
         reinterpret_cast<const sockaddr*>(&to), length);
}

}  // namespace terrace
