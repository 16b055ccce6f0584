#include "src/service/http/events.h"

#include <utility>

#include "src/service/json.h"

namespace tessera::service::http {
namespace {

bool has_ended(const proto::Event& event) {
  const std::string& state = event.status().status();
  return event.has_status() && (state == "successful" || state == "failed" || state == "dismissed");
}

}  // namespace

std::string event_text(const proto::Event& event) {
  std::string text;
  if (event.id() != 0) text += "id: " + std::to_string(event.id()) + "\n";
  if (!event.kind().empty()) text += "event: " + event.kind() + "\n";
  return text + "data: " + to_json(event) + "\n\n";
}

std::shared_ptr<const std::string> EventTexts::of(const std::shared_ptr<const proto::Event>& event) {
  Entry& entry = entries_[event->id() % kept];
  {
    const std::scoped_lock lock(mutex_);
    if (entry.event == event) return entry.text;
  }
  auto text = std::make_shared<const std::string>(event_text(*event));
  const std::scoped_lock lock(mutex_);
  entry = {event, text};
  return text;
}

EventQueue::EventQueue(EventTexts& texts, std::string job, Limits limits)
    : texts_(texts), job_(std::move(job)), limits_(limits) {}

void EventQueue::on_wake(std::function<void()> woken) {
  const std::scoped_lock lock(mutex_);
  woken_ = std::move(woken);
}

void EventQueue::add(const std::shared_ptr<const proto::Event>& event) {
  append(*texts_.of(event), !job_.empty() && event->job_id() == job_ && has_ended(*event));
}

void EventQueue::add_text(const std::string& text) { append(text, false); }

void EventQueue::append(const std::string& text, bool last) {
  const std::scoped_lock lock(mutex_);
  if (over_) return;
  const bool was_empty = waiting_.empty();
  if (waiting_.size() + text.size() > limits_.bytes) {
    // A part of the events would mislead. The watcher comes back, and says which event it had last.
    waiting_.clear();
    over_ = true;
  } else {
    waiting_ += text;
    over_ = last;
  }
  if (woken_ && (was_empty || over_)) woken_();
}

void EventQueue::end() {
  const std::scoped_lock lock(mutex_);
  over_ = true;
  if (woken_) woken_();
}

std::string EventQueue::take(bool& over) {
  const std::scoped_lock lock(mutex_);
  over = over_;
  return std::exchange(waiting_, {});
}

}  // namespace tessera::service::http
