// Work that waits, done by threads that serve no connection.
#pragma once

#include <utility>  // before awaitable.hpp of Boost 1.74, which forgets it

#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <optional>
#include <type_traits>

namespace tessera::http {

struct Workers {
  Workers(unsigned disk_threads, unsigned question_threads) : disk(disk_threads), questions(question_threads) {}
  boost::asio::thread_pool disk;       // short: what waits for a disk
  boost::asio::thread_pool questions;  // to results, which may take long; of those more wait for their turn
};

// What `work()` returns, never nothing, once a worker has called it; what it throws is thrown here. `work` is a named
// local of the coroutine that waits. Not a coroutine itself: g++ 12 destroys temporaries of such twice.
template <class Work>
boost::asio::awaitable<std::optional<std::invoke_result_t<const Work&>>> on_worker(boost::asio::thread_pool& workers,
                                                                                   const Work& work) {
  namespace asio = boost::asio;
  using Value = std::optional<std::invoke_result_t<const Work&>>;
  return asio::async_initiate<const asio::use_awaitable_t<>, void(std::exception_ptr, Value)>(
      [&workers, &work](auto handler) {
        auto executor = asio::get_associated_executor(handler);
        auto busy = asio::make_work_guard(executor);
        asio::post(workers, [&work, executor, busy = std::move(busy), handler = std::move(handler)]() mutable {
          std::exception_ptr thrown;
          Value value;
          try {
            value.emplace(work());
          } catch (...) {
            thrown = std::current_exception();
          }
          asio::post(executor, [thrown, value = std::move(value), handler = std::move(handler)]() mutable {
            handler(thrown, std::move(value));
          });
        });
      },
      asio::use_awaitable);
}

}  // namespace tessera::http
