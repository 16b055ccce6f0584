// All uses of CAF's middleman, with TLS. Each process publishes one actor at its address and reaches all others at
// theirs. CAF's own ways of finding other processes are not used, because they use ports without TLS.
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

// Loads the network with TLS. REQUIRES: certificate, key and authority can be read and fit together; CAF ends the
// process when they do not.
void load_network(caf::actor_system_config& config, const ClusterOptions& options);

// Listens at the address and publishes `door` there. Returns the port. Error io.
Result<std::uint16_t> publish(const caf::actor& door, const HostPort& listen);
void unpublish(caf::actor_system& system, const caf::actor& door, std::uint16_t port);

// Closes connections that others made longer ago than `time` and over which nothing has come that OpenSSL accepts after
// a handshake. Call it often; it is for the whole process. Returns how many were closed. When more than 128 such
// connections are open, the oldest are closed at once, without this call.
std::size_t close_mute_connections(std::chrono::milliseconds time);

// Forgets the connection to `door`. CAF keeps a handle for each address as long as the connection is there, and the
// process behind it may be gone. The address is asked anew next time.
void forget(caf::actor_system& system, const caf::actor& door);

// Connects to the actor that is published at an address, and calls done(handle) or failed(reason). Does not block. The
// connection is kept.
template <class Self, class Done, class Failed>
void reach(Self* self, const HostPort& address, Done done, Failed failed) {
  self->request(self->home_system().openssl_manager().actor_handle(), std::chrono::seconds(5), caf::connect_atom::value,
                address.host, address.port)
      .then([done](const caf::node_id&, const caf::strong_actor_ptr& there,
                   const std::set<std::string>&) { done(caf::actor_cast<caf::actor>(there)); },
            [failed](const caf::error& reason) { failed(in_words(reason)); });
}

}  // namespace tessera
