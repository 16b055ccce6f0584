// Events for one watcher, as the text of server-sent events (WHATWG HTML, 9.2). Any thread of the service adds events;
// the watcher's connection takes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "service.pb.h"
#include "src/service/http/links.h"
#include "src/service/http/message.h"
#include "src/service/jobs/jobs_backend.h"

namespace tessera::service::http {

std::string event_text(const proto::Event& event);

// Makes the text of an event once for all watchers.
class EventTexts {
 public:
  std::shared_ptr<const std::string> of(const std::shared_ptr<const proto::Event>& event);

 private:
  static constexpr std::size_t kept = 32;
  std::mutex mutex_;
  struct Entry {
    std::shared_ptr<const proto::Event> event;
    std::shared_ptr<const std::string> text;
  };
  Entry entries_[kept];
};

class EventQueue {
 public:
  struct Limits {
    std::size_t bytes = 1 << 20;  // that wait; a slower watcher is dropped
  };

  // The stream ends with the last event of `job`. If `job` is empty, it has the events of all jobs, or those of a live
  // result, and does not end.
  EventQueue(EventTexts& texts, std::string job, Limits limits);

  // `woken` is called from any thread when there is text to take. Set an empty function before `woken` becomes invalid.
  void on_wake(std::function<void()> woken);
  void add(const std::shared_ptr<const proto::Event>& event);
  void add_text(const std::string& text);
  void end();
  void keep(std::unique_ptr<Subscription> subscription) { subscription_ = std::move(subscription); }

  // Returns all text that waits. `over` is set when nothing will come after it. A watcher that was too slow gets no
  // more text.
  std::string take(bool& over);

 private:
  void append(const std::string& text, bool last);

  EventTexts& texts_;
  const std::string job_;
  const Limits limits_;
  std::mutex mutex_;
  std::string waiting_;
  bool over_ = false;
  std::function<void()> woken_;
  // Last, so that it is destroyed first and add() is not called any more.
  std::unique_ptr<Subscription> subscription_;
};

}  // namespace tessera::service::http
