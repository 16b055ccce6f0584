#include "actors/cluster/network.h"

#include <dlfcn.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <caf/io/middleman.hpp>
#include <caf/openssl/manager.hpp>
#include <chrono>
#include <map>
#include <mutex>

#include "actors/cluster/frames.h"
#include "actors/cluster/handshakes.h"
#include "src/base/check.h"

// OpenSSL keeps a list of errors for each thread, and SSL_get_error() takes any error in that list for one of the last
// call. CAF 0.17 does not clear the list. So when one peer dies, or a stranger sends garbage, the thread would close
// every other connection at its next read. Therefore the calls by which CAF reads and writes are defined here: a
// program's own definition is used before that of a library.
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t mute_max = 128;

// Connections that others have made and over which nothing valid has come yet. CAF closes none of them by itself.
class Mute {
 public:
  // Adds a connection. When there are too many, the oldest one is closed.
  void add(SSL* ssl) {
    const int socket = SSL_get_fd(ssl);
    if (socket < 0) return;  // a connection of an HTTP server in this process
    const std::lock_guard lock(mutex_);
    if (!mute_.try_emplace(ssl, Connection{socket, Clock::now()}).second) return;
    if (mute_.size() > mute_max) shut(oldest());
    count_ = mute_.size();
  }
  void remove(SSL* ssl) {
    if (count_ == 0) return;
    const std::lock_guard lock(mutex_);
    mute_.erase(ssl);
    count_ = mute_.size();
  }
  std::size_t shut_before(Clock::time_point time) {
    if (count_ == 0) return 0;
    const std::lock_guard lock(mutex_);
    std::size_t shut_now = 0;
    while (!mute_.empty() && mute_.at(oldest()).since < time) {
      shut(oldest());
      ++shut_now;
    }
    count_ = mute_.size();
    return shut_now;
  }

 private:
  struct Connection {
    int socket;
    Clock::time_point since;
  };
  SSL* oldest() const {
    return std::min_element(mute_.begin(), mute_.end(),
                            [](const auto& a, const auto& b) { return a.second.since < b.second.since; })
        ->first;
  }
  // After the shutdown CAF reads the end of the connection and closes it. The number of the socket is not in use by
  // another connection yet: CAF calls SSL_free() before it closes the socket, and that call waits for the mutex.
  void shut(SSL* ssl) {
    ::shutdown(mute_.at(ssl).socket, SHUT_RDWR);
    mute_.erase(ssl);
  }

  std::mutex mutex_;
  std::map<SSL*, Connection> mute_;
  std::atomic<std::size_t> count_{0};
};

Mute& mute() {
  static Mute all;
  return all;
}

// Returns the frame counter of a connection, which is destroyed with the connection.
tessera::IncomingFrames& frames_of(SSL* ssl) {
  static const int index =
      SSL_get_ex_new_index(0, nullptr, nullptr, nullptr, [](void*, void* frames, CRYPTO_EX_DATA*, int, long, void*) {
        delete static_cast<tessera::IncomingFrames*>(frames);
      });
  if (void* known = SSL_get_ex_data(ssl, index)) return *static_cast<tessera::IncomingFrames*>(known);
  auto* const frames = new tessera::IncomingFrames;
  SSL_set_ex_data(ssl, index, frames);
  return *frames;
}

template <class Function>
Function* openssl(const char* name) {
  auto* const found = reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
  tessera::check(found != nullptr, "OpenSSL is there");
  return found;
}

template <class Function>
Function* with_fresh_errors(const char* name) {
  ERR_clear_error();
  return openssl<Function>(name);
}

// The answer of a call after which CAF closes the connection.
int refused() {
  ERR_raise(ERR_LIB_USER, ERR_R_PASSED_INVALID_ARGUMENT);
  return -1;
}

}  // namespace

#define TESSERA_OPENSSL extern "C" __attribute__((visibility("default")))
TESSERA_OPENSSL int SSL_read(SSL* ssl, void* to, int bytes) {
  const int read = with_fresh_errors<int(SSL*, void*, int)>("SSL_read")(ssl, to, bytes);
  if (read <= 0) tessera::note_failure(ssl);
  if (read <= 0 || SSL_get_fd(ssl) < 0) return read;
  mute().remove(ssl);
  if (frames_of(ssl).take({static_cast<const unsigned char*>(to), static_cast<std::size_t>(read)})) return read;
  return refused();
}
TESSERA_OPENSSL int SSL_write(SSL* ssl, const void* from, int bytes) {
  return with_fresh_errors<int(SSL*, const void*, int)>("SSL_write")(ssl, from, bytes);
}
TESSERA_OPENSSL int SSL_accept(SSL* ssl) {
  mute().add(ssl);
  if (!tessera::watch_handshake(ssl)) return refused();
  const int done = with_fresh_errors<int(SSL*)>("SSL_accept")(ssl);
  if (done <= 0) tessera::note_failure(ssl);
  return done;
}
TESSERA_OPENSSL int SSL_connect(SSL* ssl) {
  if (!tessera::watch_handshake(ssl)) return refused();
  const int done = with_fresh_errors<int(SSL*)>("SSL_connect")(ssl);
  if (done <= 0) tessera::note_failure(ssl);
  return done;
}
TESSERA_OPENSSL void SSL_free(SSL* ssl) {
  mute().remove(ssl);
  openssl<void(SSL*)>("SSL_free")(ssl);
}
#undef TESSERA_OPENSSL

namespace tessera {

void load_network(caf::actor_system_config& config, const ClusterOptions& options) {
  config.load<caf::io::middleman>();
  config.load<caf::openssl::manager>();
  config.set("openssl.certificate", options.certificate.string());
  config.set("openssl.key", options.key.string());
  config.set("openssl.cafile", options.authority.string());
  // Messages are decoded by the thread that receives them, because the workers of the pool may be busy with tiles for
  // seconds.
  config.set("middleman.workers", std::size_t{0});
  // Leases find a process that is stopped or cut off. Messages to it are lost with the connection, and not before, so a
  // process that goes on within the grace has lost nothing. The beats end connections that are open on one side only.
  // They are not more frequent than one a second, because CAF gives up connections that are still being made when a
  // beat is due.
  const caf::timespan lease = options.lease, grace = std::chrono::seconds(options.grace_s);
  config.set("middleman.heartbeat-interval", std::max<caf::timespan>(lease / 5, std::chrono::seconds(1)));
  config.set("middleman.connection-timeout", std::max({lease, grace, caf::timespan(std::chrono::seconds(3))}));
}

Result<std::uint16_t> publish(const caf::actor& door, const HostPort& listen) {
  const auto port = caf::openssl::publish(door, listen.port, listen.host.c_str(), true);
  if (port) return *port;
  return error(Errc::io, "cannot listen at " + to_string(listen) + ": " + in_words(port.error()));
}

std::size_t close_mute_connections(std::chrono::milliseconds time) { return mute().shut_before(Clock::now() - time); }

// Sends what the middleman gets when a connection breaks: that the actor has ended.
void forget(caf::actor_system& system, const caf::actor& door) {
  caf::anon_send(caf::actor_cast<caf::actor>(system.openssl_manager().actor_handle()),
                 caf::down_msg{door.address(), caf::exit_reason::remote_link_unreachable});
}

void unpublish(caf::actor_system& system, const caf::actor& door, std::uint16_t port) {
  caf::anon_send(system.openssl_manager().actor_handle(), caf::unpublish_atom::value, door.address(), port);
}

}  // namespace tessera
