// Serves one connection: requests one after the other, each with limits of time and size.
#pragma once

#include "src/service/http/transport.h"

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "src/service/http/event_sender.h"
#include "src/service/http/front.h"
#include "src/service/http/session_limits.h"
#include "src/service/http/watched_work.h"
#include "src/service/http/workers.h"

namespace tessera::service::http {

class Session : public std::enable_shared_from_this<Session> {
 public:
  // `place` says what the listener offers. `front` must outlive the session. `workers` do the work that waits, so that
  // the threads that serve connections never wait. Join `workers` before destroying what runs sessions.
  Session(std::unique_ptr<Transport> transport, Front& front, Place place, const SessionLimits& limits,
          Workers& workers);
  ~Session();

  // Runs until the connection ends.
  asio::awaitable<void> run();
  // From any thread: begins nothing new, ends an idle connection, ends streams of events.
  void drain();
  // Stops work for this session, if there is any. REQUIRES: the session no longer runs.
  void stop_asking() {
    if (asked_) asked_->stop();
  }
  asio::any_io_executor executor() { return transport_->socket().get_executor(); }

 private:
  struct Incoming;  // a request while it is read

  void give_up_after(std::chrono::milliseconds time);
  void never_give_up() { deadline_ = std::chrono::steady_clock::time_point::max(); }  // while a worker works
  asio::awaitable<Answer> answer(Incoming& incoming);
  asio::awaitable<void> watch_time();
  asio::awaitable<bool> serve_one();
  // Why a request whose header is read is refused before its body is. `expect`: that field, in lower case.
  static std::optional<Answer> refused_by_header(const Incoming& incoming, bool folded, const std::string& expect,
                                                 unsigned version, std::uint64_t body_bytes);
  asio::awaitable<bool> read_header(Incoming& incoming);
  std::optional<Answer> take_slot(Incoming& incoming);
  Turns& turns(Runs runs) {
    if (runs == Runs::points) return *workers_.points;
    return *(runs == Runs::changes ? workers_.changes : workers_.questions);
  }
  asio::awaitable<bool> read_body(Incoming& incoming);
  asio::awaitable<bool> take_upload(Incoming& incoming);
  asio::awaitable<ErrorCode> read_more();
  asio::awaitable<bool> send(Incoming& incoming, Answer answer);
  asio::awaitable<void> linger();

  std::shared_ptr<Transport> transport_;
  Front& front_;
  const Place place_;
  const SessionLimits& limits_;
  Workers& workers_;
  boost::beast::flat_buffer buffer_;  // read and not yet parsed
  asio::steady_timer time_;
  std::chrono::steady_clock::time_point deadline_;
  std::shared_ptr<EventSender> events_;  // while events are sent
  std::shared_ptr<WatchedWork> asked_;   // while a request waits for its turn and its answer
  bool open_ = true, idle_ = true, draining_ = false, unread_ = false;
  std::string remote_;
  std::uint16_t port_ = 0;
};

}  // namespace tessera::service::http
