// Sends the events of a queue to one watcher, until the queue ends or the watcher goes.
#pragma once

#include "src/service/http/transport.h"

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <memory>

#include "src/service/http/events.h"
#include "src/service/http/session_limits.h"

namespace tessera::service::http {

// Call all functions on the socket's executor.
class EventSender : public std::enable_shared_from_this<EventSender> {
 public:
  // `give_up_after` is called with the time that the next operation may take.
  using GiveUpAfter = std::function<void(std::chrono::milliseconds)>;
  EventSender(std::shared_ptr<Transport> transport, std::shared_ptr<EventQueue> queue, const SessionLimits& limits,
              GiveUpAfter give_up_after);

  // Returns the error of the last write, if there was one.
  asio::awaitable<ErrorCode> run();
  // Ends the stream after the text that waits.
  void end();

 private:
  void watch_peer();

  std::shared_ptr<Transport> transport_;
  std::shared_ptr<EventQueue> queue_;
  const SessionLimits& limits_;
  GiveUpAfter give_up_after_;
  asio::steady_timer wake_;
  bool ending_ = false, peer_gone_ = false;
};

}  // namespace tessera::service::http
