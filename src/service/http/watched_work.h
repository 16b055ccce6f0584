// Work for a caller that waits in turn with others. The work is asked to stop when the caller has gone, or when the
// work takes longer than it may.
#pragma once

#include "src/service/http/transport.h"

#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <stop_token>

namespace tessera::service::http {

class WatchedWork : public std::enable_shared_from_this<WatchedWork> {
 public:
  // `time_max`: how long the work may take once it has begun; nothing: no limit.
  WatchedWork(std::shared_ptr<Transport> transport, std::optional<std::chrono::milliseconds> time_max);

  // Checks the caller from time to time, as long as this object lives. Call once, on the socket's executor. Bytes that
  // have come belong to the next request, and are not read.
  void watch();
  // A worker says that the work begins. From any thread, as the functions below.
  void begin();
  std::stop_token token() const { return stop_.get_token(); }
  void stop() { stop_.request_stop(); }

 private:
  std::shared_ptr<Transport> transport_;
  const std::optional<std::chrono::milliseconds> time_max_;
  std::stop_source stop_;
  asio::steady_timer look_;
  std::atomic<bool> begun_ = false;
  std::chrono::steady_clock::time_point since_;  // set before begun_
};

}  // namespace tessera::service::http
