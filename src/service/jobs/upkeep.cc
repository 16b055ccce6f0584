#include "src/service/jobs/upkeep.h"

#include <utility>

#include "src/base/thread_name.h"

namespace tessera::service {
namespace {

using std::chrono::steady_clock;
using std::chrono::system_clock;

constexpr std::chrono::milliseconds tick_time{500};
constexpr std::chrono::seconds minute{60};

}  // namespace

Upkeep::Upkeep(JobTable& table, UpkeepOptions options) : table_(table), options_(std::move(options)) {
  thread_ = std::thread([this] {
    name_thread("tick");
    run();
  });
}

Upkeep::~Upkeep() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ended_.notify_all();
  thread_.join();
}

steady_clock::duration Upkeep::silence() const {
  const std::lock_guard lock(mutex_);
  return steady_clock::now() - seen_;
}

void Upkeep::run() {
  auto next_minute = steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!ending_) {
    seen_ = steady_clock::now();
    lock.unlock();
    table_.tell_progress();
    table_.forgive_deaths(options_.lasting);
    table_.write_again();
    table_.forget_beyond();
    if (steady_clock::now() >= next_minute) {
      if (options_.retention.count() > 0) table_.forget_ended_before(system_clock::now() - options_.retention);
      if (options_.each_minute) options_.each_minute();
      next_minute = steady_clock::now() + minute;
    }
    lock.lock();
    ended_.wait_for(lock, tick_time, [this] { return ending_; });
  }
}

}  // namespace tessera::service
