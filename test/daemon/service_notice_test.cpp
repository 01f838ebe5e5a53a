// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/service_notice.h"

#include <cstdlib>
#include <cstring>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "test/datasets/temporary_folder.h"

namespace terrace {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Hears what a service manager would.
class Manager {
 public:
  Manager() : path_((folder_.path() / "notify").string()) {
    socket_ = socket(AF_UNIX, SOCK_DGRAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof(address.sun_path) - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    setenv("NOTIFY_SOCKET", path_.c_str(), 1);
  }
  ~Manager() {
    unsetenv("NOTIFY_SOCKET");
    close(socket_);
  }

  /// What has come since; empty: nothing.
  std::string Heard() const {
    char text[4096];
    const ssize_t size = recv(socket_, text, sizeof(text), MSG_DONTWAIT);
    return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : std::string();
  }

 private:
  TemporaryFolder folder_;
  std::string path_;
  int socket_ = -1;
};

Status StatusIn(DaemonState state, double fps_in, double fps_out, std::int64_t map_seq) {
  Status status;
  status.state = state;
  status.fps_in = fps_in;
  status.fps_out = fps_out;
  status.map_seq = map_seq;
  return status;
}

TEST(ServiceNoticeTest, IsReadyOnceWithTheFirstMap) {
  const Manager manager;
  ServiceNotice notice;
  notice.Tell(StatusIn(DaemonState::kNoInput, 0, 0, 0));
  EXPECT_THAT(manager.Heard(), Not(HasSubstr("READY=1")));
  notice.Tell(StatusIn(DaemonState::kRunning, 15, 15, 3));
  EXPECT_THAT(manager.Heard(), HasSubstr("\nREADY=1"));
  notice.Tell(StatusIn(DaemonState::kRunning, 15, 15, 9));
  EXPECT_THAT(manager.Heard(), Not(HasSubstr("READY=1")));
}

TEST(ServiceNoticeTest, FeedsTheWatchdogUnlessFramesComeInAndNoneComesOut) {
  const Manager manager;
  ServiceNotice notice;
  for (const auto& [status, fed] : {std::pair{StatusIn(DaemonState::kRunning, 15, 15, 3), true},
                                    {StatusIn(DaemonState::kNoInput, 0, 0, 3), true},
                                    {StatusIn(DaemonState::kNoCalibration, 0, 0, 0), true},
                                    {StatusIn(DaemonState::kPaused, 15, 15, 3), true},
                                    {StatusIn(DaemonState::kRunning, 15, 0, 3), false},
                                    {StatusIn(DaemonState::kDegraded, 15, 0, 3), false}}) {
    notice.Tell(status);
    EXPECT_EQ(manager.Heard().find("WATCHDOG=1") != std::string::npos, fed) << Name(status.state);
  }
}

TEST(ServiceNoticeTest, SaysTheReasonInOneLine) {
  const Manager manager;
  ServiceNotice notice;
  Status status = StatusIn(DaemonState::kDegraded, 15, 15, 3);
  status.reason = "dark\nREADY=1";
  notice.Tell(status);
  EXPECT_THAT(manager.Heard(), HasSubstr(": dark READY=1\n")) << "a reason is no notice";
}

TEST(ServiceNoticeTest, SaysNothingWhereNobodyAsks) {
  unsetenv("NOTIFY_SOCKET");
  ServiceNotice notice;
  notice.Tell(StatusIn(DaemonState::kRunning, 15, 15, 3));
  SUCCEED() << "and does not fail";
}

}  // namespace
}  // namespace terrace
