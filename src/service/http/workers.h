// Work that waits is done by threads that serve no connection.
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
#include <memory>
#include <optional>
#include <type_traits>

#include "src/service/http/turns.h"

namespace tessera::service::http {

// Each kind of work has its own threads, so that no kind delays another.
struct Workers {
  Workers(unsigned disk_threads, const TurnLimits& change_limits, const TurnLimits& question_limits,
          const TurnLimits& point_limits)
      : health(2),
        disk(disk_threads),
        changes(std::make_shared<Turns>(change_limits)),
        questions(std::make_shared<Turns>(question_limits)),
        points(std::make_shared<Turns>(point_limits)) {}
  void stop() {
    health.stop();
    disk.stop();
    changes->stop();
    questions->stop();
    points->stop();
  }
  void join() {
    health.join();
    disk.join();
    changes->join();
    questions->join();
    points->join();
  }

  boost::asio::thread_pool health;   // supervisors and Prometheus
  boost::asio::thread_pool disk;     // short work that waits for a disk
  std::shared_ptr<Turns> changes;    // work that reads inputs, makes jobs or removes files
  std::shared_ptr<Turns> questions;  // to results
  std::shared_ptr<Turns> points;     // of live results: work that mostly waits for a batch
};

// Returns what `work()` returns (never nothing) after a worker has called it; rethrows what it throws. `post` passes a
// function to a worker. `work` and `post` must be named locals of the coroutine that waits. This function is no
// coroutine, because g++ 12 destroys temporaries of such coroutines twice.
template <class Post, class Work>
boost::asio::awaitable<std::optional<std::invoke_result_t<const Work&>>> on_worker(const Post& post, const Work& work) {
  namespace asio = boost::asio;
  using Value = std::optional<std::invoke_result_t<const Work&>>;
  return asio::async_initiate<const asio::use_awaitable_t<>, void(std::exception_ptr, Value)>(
      [&post, &work](auto handler) {
        auto executor = asio::get_associated_executor(handler);
        auto busy = asio::make_work_guard(executor);
        post([&work, executor, busy = std::move(busy), handler = std::move(handler)]() mutable {
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

}  // namespace tessera::service::http
