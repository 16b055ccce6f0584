// A system of actors whose messages are handled one at a time, when the test says so.
#pragma once

#include <caf/all.hpp>

#include "actors/protocol.h"

namespace tessera {

class SteppedConfig : public caf::actor_system_config {
 public:
  SteppedConfig() {
    add_message_types<caf::id_block::tessera>();
    set("scheduler.policy", caf::atom("testing"));
  }
};

}  // namespace tessera
