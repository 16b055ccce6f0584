#include "src/service/live/version_events.h"

#include <utility>

namespace tessera::service {
namespace {

std::shared_ptr<const proto::Event> event_of(proto::VersionMade made) {
  auto event = std::make_shared<proto::Event>();
  event->set_id(made.version());
  event->set_kind("version");
  *event->mutable_made() = std::move(made);
  return event;
}

std::size_t boxes_in(const proto::Event& event) { return static_cast<std::size_t>(event.made().changed_size()); }

}  // namespace

class VersionEvents::Listener final : public Subscription {
 public:
  Listener(std::shared_ptr<VersionEvents> events, LiveBackend::OnVersion on_event)
      : on_event(std::move(on_event)), events_(std::move(events)) {}
  ~Listener() override { events_->leave(this); }
  const LiveBackend::OnVersion on_event;

 private:
  const std::shared_ptr<VersionEvents> events_;
};

void VersionEvents::tell(proto::VersionMade made) {
  const std::lock_guard lock(mutex_);
  newest_ = made.version();
  if (made.everything()) {
    kept_.clear();
    kept_boxes_ = 0;
  }
  kept_.push_back(event_of(std::move(made)));
  kept_boxes_ += boxes_in(*kept_.back());
  for (; kept_.size() > 1 && (kept_.size() > kept_max || kept_boxes_ > kept_boxes_max); kept_.pop_front())
    kept_boxes_ -= boxes_in(*kept_.front());
  for (const Listener* listener : listeners_) listener->on_event(kept_.back());
}

void VersionEvents::tell_stored(std::uint64_t number) {
  auto event = std::make_shared<proto::Event>();
  event->set_kind("stored");
  event->mutable_made()->set_version(number);
  const std::lock_guard lock(mutex_);
  for (const Listener* listener : listeners_) listener->on_event(event);
}

std::unique_ptr<Subscription> VersionEvents::follow(std::optional<std::uint64_t> last,
                                                    LiveBackend::OnVersion on_event) {
  auto listener = std::make_unique<Listener>(shared_from_this(), std::move(on_event));
  const std::lock_guard lock(mutex_);
  listeners_.push_back(listener.get());
  if (!last || *last == newest_) return listener;
  const bool known = *last < newest_ && !kept_.empty() && kept_.front()->id() <= *last + 1;
  if (!known) {
    proto::VersionMade missed;
    missed.set_version(newest_);
    missed.set_everything(true);
    listener->on_event(event_of(std::move(missed)));
    return listener;
  }
  for (const Event& event : kept_)
    if (event->id() > *last) listener->on_event(event);
  return listener;
}

void VersionEvents::leave(const Listener* listener) {
  const std::lock_guard lock(mutex_);
  std::erase(listeners_, listener);
}

}  // namespace tessera::service
