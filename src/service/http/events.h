// Events on their way to one watcher, as the text of server-sent events (WHATWG HTML, 9.2). The service adds them from
// any thread; the watcher's connection takes them out.
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
#include "src/service/service.h"

namespace tessera::http {

std::string event_text(const proto::Event& event);

// The same text for all watchers of an event: it is made once.
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
    std::size_t bytes = 1 << 20;  // that wait; a watcher that is slower is dropped
  };

  // `job`: the stream ends with its last event; empty: of all jobs, without an end.
  EventQueue(EventTexts& texts, std::string job, Limits limits);

  // `woken` is called, from any thread, when something is there to take; replaced by nothing before it dies.
  void on_wake(std::function<void()> woken);
  void add(const std::shared_ptr<const proto::Event>& event);
  void add_text(const std::string& text);
  void end();
  void keep(std::unique_ptr<Backend::Subscription> subscription) { subscription_ = std::move(subscription); }

  // All that waits; `over`: nothing will come after it. A watcher that was too slow gets nothing more.
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
  // Last: it ends first, and with it the calls of add().
  std::unique_ptr<Backend::Subscription> subscription_;
};

}  // namespace tessera::http
