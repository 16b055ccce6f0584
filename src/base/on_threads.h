// Runs the same work on several threads.
#pragma once

#include <atomic>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/ledger.h"
#include "src/base/result.h"
#include "src/base/stopped.h"

namespace tessera {

// Runs work() on `threads` threads, one of which is the calling thread. All threads draw from the ledger of the calling
// thread. Returns the first error. When a thread fails, `failed` becomes true, and `work` should look at it and end
// early.
template <class Work>
Status on_threads(unsigned threads, std::atomic<bool>& failed, const Work& work) {
  std::mutex mutex;
  std::optional<Error> first;
  const auto guarded = [&, ledger = Ledger::of_thread()] {
    const Ledger::Use use(ledger);
    Status status = [&]() -> Status {
      try {
        return work();
      } catch (const Stopped&) {
        return error(Errc::interrupted, "interrupted");
      } catch (const std::bad_alloc&) {
        return worded([] { return error(Errc::memory, "no memory is left to work on"); });
      }
    }();
    if (status) return;
    failed = true;
    const std::lock_guard lock(mutex);
    if (!first) first = std::move(status).error();
  };
  {
    std::vector<std::jthread> others;
    for (unsigned t = 1; t < threads; ++t) others.emplace_back(guarded);
    guarded();
  }
  if (first) return *first;
  return success();
}

}  // namespace tessera
