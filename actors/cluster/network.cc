#include "actors/cluster/network.h"

#include <dlfcn.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <caf/io/middleman.hpp>
#include <caf/openssl/manager.hpp>

#include "src/base/check.h"

// OpenSSL keeps a list of errors a thread, and SSL_get_error() takes any that is there for one of the call before it.
// CAF 0.17 does not clear the list: when one peer dies, or a stranger sends garbage, the thread closes every other
// connection at its next read. So the calls by which CAF reads and writes come by here, as whatever the program defines
// comes before what its libraries do.
namespace {

template <class Function>
Function* openssl(const char* name) {
  ERR_clear_error();
  auto* const found = reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
  tessera::check(found != nullptr, "OpenSSL is there");
  return found;
}

}  // namespace

#define TESSERA_FRESH_ERRORS(result, name, parameters, ...)                  \
  extern "C" __attribute__((visibility("default"))) result name parameters { \
    return openssl<result parameters>(#name)(__VA_ARGS__);                   \
  }
TESSERA_FRESH_ERRORS(int, SSL_read, (SSL * ssl, void* to, int bytes), ssl, to, bytes)
TESSERA_FRESH_ERRORS(int, SSL_write, (SSL * ssl, const void* from, int bytes), ssl, from, bytes)
TESSERA_FRESH_ERRORS(int, SSL_accept, (SSL * ssl), ssl)
TESSERA_FRESH_ERRORS(int, SSL_connect, (SSL * ssl), ssl)
#undef TESSERA_FRESH_ERRORS

namespace tessera {

void load_network(caf::actor_system_config& config, const ClusterOptions& options) {
  config.load<caf::io::middleman>();
  config.load<caf::openssl::manager>();
  config.set("openssl.certificate", options.certificate.string());
  config.set("openssl.key", options.key.string());
  config.set("openssl.cafile", options.authority.string());
  // What arrives is read by the thread that receives it: workers of the pool may be at work on tiles for seconds.
  config.set("middleman.workers", std::size_t{0});
  // Who is stopped, or cut off, is found out by silence. Not shorter than a second: CAF gives up connections that are
  // still being made when a beat is due.
  const caf::timespan lease = options.lease;
  config.set("middleman.heartbeat-interval", std::max<caf::timespan>(lease / 5, std::chrono::seconds(1)));
  config.set("middleman.connection-timeout", std::max<caf::timespan>(lease, std::chrono::seconds(3)));
}

Result<std::uint16_t> publish(caf::actor_system& system, const caf::actor& door, const HostPort& listen) {
  const auto port = caf::openssl::publish(door, listen.port, listen.host.c_str(), true);
  if (port) return *port;
  return error(Errc::io, "cannot listen at " + to_string(listen) + ": " + system.render(port.error()));
}

void unpublish(caf::actor_system& system, const caf::actor& door, std::uint16_t port) {
  caf::anon_send(system.openssl_manager().actor_handle(), caf::unpublish_atom::value, door.address(), port);
}

}  // namespace tessera
