// Delivers the versions of a live result to those who follow it, in order. The thread that makes a version calls the
// listeners.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "service.pb.h"
#include "src/service/live/live_backend.h"

namespace tessera::service {

// Thread-safe. Subscriptions may outlive this object.
class VersionEvents : public std::enable_shared_from_this<VersionEvents> {
 public:
  // Who comes back gets all versions that were missed at once, which must not be more than a queue takes
  // (EventQueue::Limits).
  static constexpr std::size_t kept_max = 1000, kept_boxes_max = 3000;

  // `newest`: the number of the version that is there already.
  explicit VersionEvents(std::uint64_t newest) : newest_(newest) {}

  void tell(proto::VersionMade made);
  // Those who listen now hear that the version with this number is stored. Nobody hears it later.
  void tell_stored(std::uint64_t number);
  // Delivers versions after `last`; nothing: from now on.
  std::unique_ptr<Subscription> follow(std::optional<std::uint64_t> last, LiveBackend::OnVersion on_event);

 private:
  using Event = std::shared_ptr<const proto::Event>;
  class Listener;
  void leave(const Listener* listener);

  std::mutex mutex_;  // held while listeners are called, so that none is called after it has left
  std::uint64_t newest_;
  std::deque<Event> kept_;
  std::size_t kept_boxes_ = 0;
  std::vector<Listener*> listeners_;
};

}  // namespace tessera::service
