#include "src/service/deadline.h"

#include <string>
#include <utility>

#include "src/base/thread_name.h"

namespace tessera::service {

Deadline::Deadline(Ledger& ledger, std::chrono::seconds time, Error over)
    : timer_([this, &ledger, time, over = std::move(over)](const std::stop_token& done) {
        name_thread("deadline");
        {
          std::unique_lock lock(mutex_);
          if (ended_.wait_for(lock, done, time, [&] { return done.stop_requested(); })) return;
        }
        ledger.stop(over);
      }) {}

WhileAnyoneWaits::WhileAnyoneWaits(const std::stop_token& gone)
    : ledger_({.files = {names_max, "a request"}}),
      deadline_(ledger_, answer_time, time_is_over(answer_time)),
      when_gone_(gone, [this] { ledger_.stop(); }),
      use_(&ledger_) {}

Error time_is_over(std::chrono::seconds time) {
  return error(Errc::memory, "the answer takes longer than the " + std::to_string(time.count()) +
                                 " seconds that a question may take: ask for less at a time");
}

}  // namespace tessera::service
