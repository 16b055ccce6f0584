#include "src/service/http/incoming.h"

#include <poll.h>
#include <sys/socket.h>

#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cerrno>
#include <chrono>

namespace tessera::http {

using asio::redirect_error;
using asio::use_awaitable;

asio::awaitable<ErrorCode> Session::send_events(EventQueue& queue) {
  ErrorCode error;
  const std::function<void()> progress = [this] { give_up_after(limits_.write); }, no_matter = [] {};
  queue.on_wake([weak = weak_from_this(), executor = transport_->socket().get_executor()] {
    asio::post(executor, [weak] {
      if (const auto self = weak.lock()) self->wake_.cancel();
    });
  });
  watch_peer();
  while (!error) {
    bool over = false;
    const std::string text = queue.take(over);
    if (!text.empty()) {
      progress();
      error = co_await transport_->write(text, {}, progress);
      continue;
    }
    if (over || peer_gone_ || draining_) break;
    // No awaiting between take() and here, so no wake-up is lost.
    give_up_after(limits_.comment + limits_.write);
    wake_.expires_after(limits_.comment);
    ErrorCode woken;
    co_await wake_.async_wait(redirect_error(use_awaitable, woken));
    if (!woken) error = co_await transport_->write(": still here\n\n", {}, no_matter);
  }
  co_return error;
}

// Notices at once when a watcher goes, not only with the next comment.
void Session::watch_peer() {
  transport_->socket().async_wait(tcp::socket::wait_read, [weak = weak_from_this()](ErrorCode error) {
    const auto self = weak.lock();
    if (error || !self) return;
    char byte = 0;
    const ssize_t seen = ::recv(self->transport_->socket().native_handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT);
    // The event loop may report late that the request came, which was read long ago.
    if (seen < 0 && errno == EAGAIN) return self->watch_peer();
    // Under TLS it is the closing message, because watchers send nothing else.
    if (seen > 0 && !self->transport_->is_tls()) return;
    self->peer_gone_ = true;
    self->wake_.cancel();
  });
}

// Checks from time to time whether the caller is still there. Bytes that have come belong to the next request, and are
// not read.
void Session::watch_caller(Runs runs) {
  constexpr std::chrono::milliseconds between{200};
  look_.expires_after(between);
  look_.async_wait([weak = weak_from_this(), runs](ErrorCode error) {
    const auto self = weak.lock();
    if (error || !self || !self->asked_) return;
    Asked& asked = *self->asked_;
    pollfd peer{self->transport_->socket().native_handle(), POLLRDHUP, 0};
    const bool late =
        runs == Runs::changes && asked.begun && std::chrono::steady_clock::now() - asked.since > self->limits_.work;
    if (late || ::poll(&peer, 1, 0) > 0) {
      asked.stop.request_stop();
    } else {
      self->watch_caller(runs);
    }
  });
}

}  // namespace tessera::http
