// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tools/view_feed.h"
#include "tools/view_record.h"

namespace terrace {

struct ViewServerOptions {
  std::string address = "127.0.0.1";  ///< where it listens; loopback: only browsers of this machine
  int port = 8080;                    ///< 0: any that is free
};

/// What it has for browsers.
struct ViewContent {
  std::string page;                      ///< the HTML
  std::optional<std::string> recording;  ///< a recording that the page plays; none: live
  /// Carries out "pause", "resume", "reset", "snapshot" and "save"; null: this viewer is read-only.
  std::function<void(const std::string& command)> command;
};

/// Serves the page over HTTP and the records over a WebSocket to any number of browsers, from one thread. A
/// browser that reads slowly is sent less, and costs no memory but the one message that is under way.
class ViewServer {
 public:
  /// Listens from here on. Throws std::runtime_error when the address cannot be used.
  /// @param feed  what is live; used inside Run() only
  ViewServer(const ViewServerOptions& options, ViewContent content, ViewFeed* feed);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// Until Stop().
  void Run();
  /// From any thread.
  void Stop();
  /// Has the feed changed inside Run(), then every browser sent what it lacks. From any thread.
  void Change(std::function<void(ViewFeed*)> change);
  /// What any browser wants. From any thread.
  ViewSlots wanted() const;

  int port() const;
  std::size_t num_browsers() const;  ///< from any thread

 private:
  struct Loop;
  class Impl;
  // Last destroyed: what still waits in the loop holds browsers, and they hold the rest.
  std::unique_ptr<Loop> loop_;
  std::shared_ptr<Impl> impl_;
};

}  // namespace terrace
