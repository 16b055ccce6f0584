// A message made in advance, so that an actor can say that memory has run out without needing memory.
#pragma once

#include <caf/all.hpp>
#include <utility>

namespace tessera {

template <class Message>
class Prepared {
 public:
  Prepared()
      : element_(caf::make_mailbox_element(nullptr, caf::make_message_id(), caf::no_stages, Message{})),
        message_(&element_->content().template get_mutable_as<Message>(0)) {}

  // The message that will be sent. REQUIRES: it was not sent.
  Message& message() { return *message_; }
  bool said() const { return !element_; }
  // Sends the message, the first time that it is called. Does nothing when `to` is null.
  template <class Handle>
  void say(const Handle& to) noexcept {
    using Messages = caf::detail::type_list<Message>;
    static_assert(caf::response_type_unbox<caf::signatures_of_t<Handle>, Messages>::valid, "the receiver takes it");
    if (element_ && to) caf::actor_cast<caf::abstract_actor*>(to)->enqueue(std::move(element_), nullptr);
  }

 private:
  caf::mailbox_element_ptr element_;
  Message* message_;
};

}  // namespace tessera
