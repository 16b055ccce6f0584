#include "src/service/http/watched_work.h"

#include <poll.h>

#include <utility>

namespace tessera::service::http {

WatchedWork::WatchedWork(std::shared_ptr<Transport> transport, std::optional<std::chrono::milliseconds> time_max)
    : transport_(std::move(transport)), time_max_(time_max), look_(transport_->socket().get_executor()) {}

void WatchedWork::begin() {
  since_ = std::chrono::steady_clock::now();
  begun_ = true;
}

void WatchedWork::watch() {
  constexpr std::chrono::milliseconds between{200};
  look_.expires_after(between);
  look_.async_wait([weak = weak_from_this()](ErrorCode error) {
    const auto self = weak.lock();
    if (error || !self) return;
    pollfd peer{self->transport_->socket().native_handle(), POLLRDHUP, 0};
    const bool late =
        self->time_max_ && self->begun_ && std::chrono::steady_clock::now() - self->since_ > *self->time_max_;
    if (late || ::poll(&peer, 1, 0) > 0) {
      self->stop();
    } else {
      self->watch();
    }
  });
}

}  // namespace tessera::service::http
