// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_server.h"

#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <terrace/command_reply_v1_t.hpp>

namespace terrace {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Request = http::request<http::string_body>;

constexpr auto kHttpTimeout = std::chrono::seconds(30);
constexpr std::size_t kMaxBrowsers = 32;
constexpr std::size_t kMaxRequestBytes = 4096;
// What the kernel keeps for a browser that does not read; what is newer waits as a difference, not as bytes.
constexpr int kSendBufferBytes = 256 * 1024;

/// The name before the port of "localhost:8080" or "[::1]:8080".
std::string HostName(std::string_view host) {
  const std::size_t end = host.starts_with('[') ? host.find(']') + 1 : host.find(':');
  return std::string(host.substr(0, end));
}

bool IsLoopbackName(const std::string& name) {
  return name == "localhost" || name == "[::1]" || name.starts_with("127.");
}

/// Words that are no slot are passed over: a page may be newer than this program.
ViewSlots SlotsOf(const nlohmann::json& names) {
  static const std::map<std::string, ViewSlot> kNames = {{"image", ViewSlot::kImage},
                                                         {"disparity", ViewSlot::kDisparity},
                                                         {"cells", ViewSlot::kCells},
                                                         {"points", ViewSlot::kPoints}};
  ViewSlots slots;
  for (const nlohmann::json& name : names) {
    if (!name.is_string()) continue;
    const auto known = kNames.find(name.get<std::string>());
    if (known != kNames.end()) slots.Add(known->second);
  }
  return slots;
}

}  // namespace

struct ViewServer::Loop {
  asio::io_context io{1};
};

class ViewServer::Impl : public std::enable_shared_from_this<Impl> {
 public:
  Impl(asio::io_context* io, const ViewServerOptions& options, ViewContent given, ViewFeed* feed_given)
      : content(std::move(given)), feed(feed_given), acceptor(*io) {
    beast::error_code error;
    const asio::ip::address address = asio::ip::make_address(options.address, error);
    if (error) throw std::runtime_error(options.address + ": is no address of a network interface");
    only_loopback = address.is_loopback();
    const tcp::endpoint endpoint(address, static_cast<unsigned short>(options.port));
    acceptor.open(endpoint.protocol());
    acceptor.set_option(asio::socket_base::reuse_address(true));
    acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      throw std::runtime_error("port " + std::to_string(options.port) + " of " + options.address +
                               " cannot be used: " + error.message());
    }
  }

  void Accept();
  void CountWishes();
  void WakeAll();

  class Browser;
  class Connection;

  ViewContent content;
  ViewFeed* feed;
  tcp::acceptor acceptor;
  bool only_loopback = true;
  std::set<std::shared_ptr<Browser>> browsers;
  std::atomic<ViewSlots> wanted{};
  std::atomic<std::size_t> num_browsers = 0;
};

/// A WebSocket: one message is under way at a time; the next one is made when that is out.
class ViewServer::Impl::Browser : public std::enable_shared_from_this<Browser> {
 public:
  Browser(std::shared_ptr<Impl> server, beast::tcp_stream stream)
      : server_(std::move(server)), socket_(std::move(stream)), cursor_(server_->feed) {
    socket_.read_message_max(kMaxRequestBytes);
    socket_.binary(true);
    // A browser may stand still for as long as it likes, as one does whose laptop is closed.
    socket_.set_option(websocket::stream_base::timeout{kHttpTimeout, websocket::stream_base::none(), false});
  }

  void Start(const Request& request) {
    socket_.async_accept(request, [self = shared_from_this()](beast::error_code error) {
      if (error) return;
      self->server_->browsers.insert(self);
      self->server_->CountWishes();
      self->Read();
      self->Write();
    });
  }

  void Write() {
    if (writing_) return;
    if (!answers_.empty()) {
      under_way_ = std::move(answers_.front());
      answers_.pop_front();
    } else {
      under_way_ = cursor_.Next();
    }
    if (!under_way_) return;
    writing_ = true;
    socket_.async_write(asio::buffer(*under_way_),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                          self->writing_ = false;
                          self->under_way_ = nullptr;
                          if (error) return self->Leave();
                          self->Write();
                        });
  }

  const ViewSlots& wants() const { return cursor_.wants(); }

 private:
  void Read() {
    socket_.async_read(incoming_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) return self->Leave();
      const std::string text = beast::buffers_to_string(self->incoming_.data());
      self->incoming_.consume(self->incoming_.size());
      self->Obey(text);
      self->Read();
    });
  }

  void Obey(const std::string& text) {
    const nlohmann::json request = nlohmann::json::parse(text, nullptr, false);
    if (!request.is_object()) return;
    if (const auto wishes = request.find("wants"); wishes != request.end() && wishes->is_array()) {
      cursor_.SetWants(SlotsOf(*wishes));
      server_->CountWishes();
    }
    if (request.contains("snapshot")) cursor_.Restart();
    if (const auto command = request.find("command"); command != request.end() && command->is_string()) {
      if (server_->content.command)
        server_->content.command(command->get<std::string>());
      else
        Refuse();
    }
    Write();
  }

  void Refuse() {
    command_reply_v1_t reply{};
    reply.result = command_reply_v1_t::REFUSED;
    reply.message = "this view only looks: terrace view was started without --control";
    answers_.push_back(MakeViewRecord(ViewRecordKind::kReply, {}, {}, reply));
    if (answers_.size() > 4) answers_.pop_front();
  }

  void Leave() {
    server_->browsers.erase(shared_from_this());
    server_->CountWishes();
  }

  std::shared_ptr<Impl> server_;
  websocket::stream<beast::tcp_stream> socket_;
  ViewCursor cursor_;
  beast::flat_buffer incoming_;
  std::deque<ViewBytes> answers_;
  ViewBytes under_way_;
  bool writing_ = false;
};

/// One HTTP connection: answers requests, or becomes a Browser.
class ViewServer::Impl::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(std::shared_ptr<Impl> server, tcp::socket socket)
      : server_(std::move(server)), stream_(std::move(socket)) {}

  void Read() {
    request_ = {};
    stream_.expires_after(kHttpTimeout);
    http::async_read(stream_, buffer_, request_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       if (!error) self->Answer();
                     });
  }

 private:
  /// A page of somebody else that is open in the same browser must not reach the robot: not under a name of
  /// its own for this address, and not from its own origin.
  bool IsOurs() const {
    const std::string host(request_[http::field::host]);
    const std::string origin(request_[http::field::origin]);
    if (server_->only_loopback && !IsLoopbackName(HostName(host))) return false;
    return origin.empty() || origin == "http://" + host;
  }

  void Answer() {
    const std::string target(request_.target().substr(0, request_.target().find('?')));
    if (!IsOurs()) return Send(http::status::forbidden, "text/plain", "asked under a foreign name");
    if (websocket::is_upgrade(request_) && target == "/stream") return Upgrade();
    if (request_.method() != http::verb::get) return Send(http::status::method_not_allowed, "text/plain", "");
    if (target == "/" || target == "/index.html") {
      return Send(http::status::ok, "text/html; charset=utf-8", server_->content.page);
    }
    if (target == "/recording") {
      const auto& recording = server_->content.recording;
      if (recording) return Send(http::status::ok, "application/octet-stream", *recording);
      // No error, so that the browser's console stays clean: what is shown is live.
      return Send(http::status::no_content, "text/plain", "");
    }
    Send(http::status::not_found, "text/plain", "there is nothing here");
  }

  void Upgrade() {
    if (server_->content.recording || server_->browsers.size() >= kMaxBrowsers) {
      return Send(http::status::service_unavailable, "text/plain", "nothing live, or too many browsers");
    }
    stream_.expires_never();
    beast::error_code ignored;  // a browser that has gone already is found out by the first message
    stream_.socket().set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
    stream_.socket().set_option(asio::socket_base::keep_alive(true), ignored);
    stream_.socket().set_option(tcp::no_delay(true), ignored);
    std::make_shared<Browser>(server_, std::move(stream_))->Start(request_);
  }

  void Send(http::status status, const char* type, const std::string& body) {
    response_ = {status, request_.version()};
    response_.set(http::field::content_type, type);
    response_.set(http::field::cache_control, "no-store");
    response_.set(http::field::x_frame_options, "DENY");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.keep_alive(request_.keep_alive());
    if (status != http::status::no_content) {
      response_.body() = body;
      response_.prepare_payload();
    }
    http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) return;
      if (self->response_.keep_alive()) return self->Read();
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
    });
  }

  std::shared_ptr<Impl> server_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kMaxRequestBytes * 4};
  Request request_;
  http::response<http::string_body> response_;
};

void ViewServer::Impl::Accept() {
  acceptor.async_accept([self = shared_from_this()](beast::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error) std::make_shared<Connection>(self, std::move(socket))->Read();
    self->Accept();
  });
}

void ViewServer::Impl::CountWishes() {
  ViewSlots all;
  for (const auto& browser : browsers) all.Add(browser->wants());
  wanted = all;
  num_browsers = browsers.size();
}

void ViewServer::Impl::WakeAll() {
  for (const auto& browser : browsers) browser->Write();
}

ViewServer::ViewServer(const ViewServerOptions& options, ViewContent content, ViewFeed* feed)
    : loop_(std::make_unique<Loop>()),
      impl_(std::make_shared<Impl>(&loop_->io, options, std::move(content), feed)) {
  impl_->Accept();
}

ViewServer::~ViewServer() { impl_->browsers.clear(); }

void ViewServer::Run() { loop_->io.run(); }

void ViewServer::Stop() { loop_->io.stop(); }

void ViewServer::Change(std::function<void(ViewFeed*)> change) {
  asio::post(loop_->io, [impl = impl_, change = std::move(change)] {
    change(impl->feed);
    impl->WakeAll();
  });
}

ViewSlots ViewServer::wanted() const { return impl_->wanted; }

int ViewServer::port() const { return impl_->acceptor.local_endpoint().port(); }

std::size_t ViewServer::num_browsers() const { return impl_->num_browsers; }

}  // namespace terrace
