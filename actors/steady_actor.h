// Base of every actor: none ends the process, however little memory there is, or ends unheard.
//
// CAF catches what a handler throws, and then ends the actor outside of any try block: what fails there is
// std::terminate. So an actor says its last word in on_exit(), at the latest, with a message that it has prepared; it
// gives CAF no reason for its end, which would have to be copied; and the messages that CAF makes for those who monitor
// it are the only ones that may be lost.
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
      return true;  // the actor is over; on_exit() has told whom it concerns
    }
  }

  // Nobody knows it any more. CAF would give a reason here.
  void on_destroy() override {
    if (!this->getf(caf::abstract_actor::is_cleaned_up_flag)) {
      this->on_exit();
      cleanup({}, nullptr);
    }
    Handle::base::on_destroy();
  }

 private:
  // A handler has thrown: the actor ends now, on_exit() comes next.
  virtual void failed(const std::exception_ptr& exception) noexcept = 0;
};

}  // namespace tessera
