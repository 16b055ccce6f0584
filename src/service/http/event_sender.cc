#include "src/service/http/event_sender.h"

#include <sys/socket.h>

#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cerrno>
#include <string>
#include <utility>

namespace tessera::service::http {

using asio::redirect_error;
using asio::use_awaitable;

EventSender::EventSender(std::shared_ptr<Transport> transport, std::shared_ptr<EventQueue> queue,
                         const SessionLimits& limits, GiveUpAfter give_up_after)
    : transport_(std::move(transport)),
      queue_(std::move(queue)),
      limits_(limits),
      give_up_after_(std::move(give_up_after)),
      wake_(transport_->socket().get_executor()) {}

asio::awaitable<ErrorCode> EventSender::run() {
  ErrorCode error;
  const std::function<void()> progress = [this] { give_up_after_(limits_.write); }, no_matter = [] {};
  queue_->on_wake([weak = weak_from_this(), executor = transport_->socket().get_executor()] {
    asio::post(executor, [weak] {
      if (const auto self = weak.lock()) self->wake_.cancel();
    });
  });
  watch_peer();
  while (!error) {
    bool over = false;
    const std::string text = queue_->take(over);
    if (!text.empty()) {
      progress();
      error = co_await transport_->write(text, {}, progress);
      continue;
    }
    if (over || peer_gone_ || ending_) break;
    // No awaiting between take() and here, so no wake-up is lost.
    give_up_after_(limits_.comment + limits_.write);
    wake_.expires_after(limits_.comment);
    ErrorCode woken;
    co_await wake_.async_wait(redirect_error(use_awaitable, woken));
    if (!woken) error = co_await transport_->write(": still here\n\n", {}, no_matter);
  }
  queue_->on_wake({});
  co_return error;
}

void EventSender::end() {
  ending_ = true;
  queue_->end();
}

// Notices at once when the watcher goes, not only with the next comment.
void EventSender::watch_peer() {
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

}  // namespace tessera::service::http
