// CAF's middleman, with TLS: all that is used of it. Each process publishes one actor at its address and reaches every
// other one there, for CAF's own ways of finding others use ports without TLS.
#pragma once

#include <caf/all.hpp>
#include <caf/openssl/all.hpp>
#include <chrono>
#include <cstdint>
#include <set>
#include <string>

#include "actors/failing.h"
#include "src/base/result.h"
#include "src/cluster/cluster_options.h"

namespace tessera {

// REQUIRES: certificate, key and authority can be read and fit together; CAF ends the process when they do not.
void load_network(caf::actor_system_config& config, const ClusterOptions& options);

// Listens. Returns the port. Error io.
Result<std::uint16_t> publish(const caf::actor& door, const HostPort& listen);
void unpublish(caf::actor_system& system, const caf::actor& door, std::uint16_t port);

// Ends connections that others made longer ago than that and over which they have sent nothing that counts: no word
// after a handshake with a certificate of the cluster. Of the whole process; to be called often. Beside them there are
// never more than 128. Returns how many.
std::size_t close_mute_connections(std::chrono::milliseconds time);

// Whoever is reached at an address is kept by it as long as the connection is there, which may be one to a process that
// is no more: at its address is asked anew next time.
void forget(caf::actor_system& system, const caf::actor& door);

// Reaches the actor that is published there: done(handle), or failed(reason). Does not block; the connection is kept.
template <class Self, class Done, class Failed>
void reach(Self* self, const HostPort& address, Done done, Failed failed) {
  self->request(self->home_system().openssl_manager().actor_handle(), std::chrono::seconds(5), caf::connect_atom::value,
                address.host, address.port)
      .then([done](const caf::node_id&, const caf::strong_actor_ptr& there,
                   const std::set<std::string>&) { done(caf::actor_cast<caf::actor>(there)); },
            [failed](const caf::error& reason) { failed(in_words(reason)); });
}

}  // namespace tessera
