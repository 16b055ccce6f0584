#include "src/service/client/patience.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>

namespace tessera::client {

void Patience::restart() {
  heard_ = Clock::now();
  pause_ = shortest;
}

Status Patience::wait(const Error& why, const std::stop_token& stop) {
  if (Clock::now() - heard_ > length_) return why;
  return pause(stop);
}

Status Patience::pause(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any wake;
  std::unique_lock lock(mutex);
  wake.wait_for(lock, stop, pause_, [] { return false; });
  if (stop.stop_requested()) return error(Errc::interrupted, "interrupted");
  pause_ = std::min(pause_ * 2, longest);
  return success();
}

}  // namespace tessera::client
