// Work that several threads do, and whose results one thread uses in order.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/objects.h"

namespace tessera {

// Calls take(i, make(i)) for i = 0 .. n-1. `make` returns a Result and runs on up to `threads` threads (at most 16),
// ahead of `take` by at most twice as many results. `take` returns a Status and runs on the calling thread, by
// ascending i. Returns the error of the lowest i, whatever the number of threads. No result of a higher i is taken
// then.
template <class Make, class Take>
Status in_order(std::size_t n, unsigned threads, const Make& make, const Take& take) {
  using Made = decltype(make(std::size_t{}));
  // Sixteen read 100 million points a second from text; what waits to be taken needs memory.
  threads = std::min(threads, 16U);
  if (threads <= 1 || n <= 1) {
    for (std::size_t i = 0; i < n; ++i) {
      BOOST_OUTCOME_TRY(made, make(i));
      BOOST_OUTCOME_TRYV(take(i, std::move(made)));
    }
    return success();
  }
  struct Shared {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::optional<Made>> slots;
    std::size_t next = 0, front = 0;  // the next i to be made, and to be taken
    bool stop = false;
  } shared;
  shared.slots.resize(2 * std::size_t{threads});
  const auto work = [&, objects = UseObjects::of_thread()] {
    const UseObjects use(objects);
    std::unique_lock lock(shared.mutex);
    while (true) {
      shared.changed.wait(
          lock, [&] { return shared.stop || shared.next == n || shared.next < shared.front + shared.slots.size(); });
      if (shared.stop || shared.next == n) return;
      const std::size_t i = shared.next++;
      lock.unlock();
      Made made = [&]() -> Made {
        try {
          return make(i);
        } catch (const std::bad_alloc&) {
          return worded([] { return error(Errc::memory, "no memory is left to read the input files"); });
        }
      }();
      lock.lock();
      // What comes after an error is not needed. What comes before it has already begun.
      shared.stop = shared.stop || made.has_error();
      shared.slots[i % shared.slots.size()].emplace(std::move(made));
      shared.changed.notify_all();
    }
  };
  struct Workers {
    ~Workers() {
      {
        const std::lock_guard lock(shared.mutex);
        shared.stop = true;
      }
      shared.changed.notify_all();
    }
    Shared& shared;
    std::vector<std::jthread> threads;
  } workers{shared, {}};
  for (std::size_t t = 0; t < std::min<std::size_t>(threads, n); ++t) workers.threads.emplace_back(work);

  for (std::size_t i = 0; i < n; ++i) {
    std::unique_lock lock(shared.mutex);
    auto& slot = shared.slots[i % shared.slots.size()];
    shared.changed.wait(lock, [&] { return slot.has_value(); });
    Made made = std::move(*slot);
    slot.reset();
    shared.front = i + 1;
    shared.changed.notify_all();
    lock.unlock();
    if (made.has_error()) return std::move(made).error();
    BOOST_OUTCOME_TRYV(take(i, std::move(made).value()));
  }
  return success();
}

}  // namespace tessera
