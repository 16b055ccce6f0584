// Base of all actors. However little memory there is, no actor ends the process, and none ends without its last
// message.
//
// CAF catches an exception of a handler, and then ends the actor outside of any try block, so a failure there is
// std::terminate. So an actor sends its last message in on_exit(), at the latest, and has made that message in advance.
// An actor gives CAF no reason for its end, because CAF would copy the reason. Only the messages that CAF makes for
// actors that monitor this one may be lost.
#pragma once

#include <caf/all.hpp>
#include <exception>
#include <new>

#include "actors/scheduler.h"

namespace tessera {

template <class Handle, Pool pool>
class SteadyActor : public Handle::base, public Schedulable {
 public:
  explicit SteadyActor(caf::actor_config& config) : Handle::base(config), Schedulable(this, pool) {
    this->set_exception_handler([this](std::exception_ptr& exception) -> caf::error {
      failed(exception);
      return {};
    });
  }

  bool cleanup(caf::error&& reason, caf::execution_unit* host) override {
    try {
      return Handle::base::cleanup(std::move(reason), host);
    } catch (const std::bad_alloc&) {
      return true;  // the actor has ended; on_exit() has told all that must be told
    }
  }

  // The last reference is gone. CAF's own version would make a reason here, which takes memory.
  void on_destroy() override {
    if (!this->getf(caf::abstract_actor::is_cleaned_up_flag)) {
      this->on_exit();
      cleanup({}, nullptr);
    }
    Handle::base::on_destroy();
  }

 private:
  // A handler has thrown. The actor ends now, and on_exit() is called next.
  virtual void failed(const std::exception_ptr& exception) noexcept = 0;
};

}  // namespace tessera
