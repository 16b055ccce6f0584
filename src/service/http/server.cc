#include "src/service/http/server.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <utility>

#include "src/base/files/open_files.h"
#include "src/base/thread_name.h"
#include "src/service/http/connection_counts.h"
#include "src/service/http/front.h"
#include "src/service/http/session.h"
#include "src/service/http/tls.h"

namespace tessera::service::http {
namespace {

constexpr std::chrono::milliseconds accept_again{100};
constexpr std::chrono::seconds between_refusals{1};

Error listen_error(const ListenOptions& listen, const ErrorCode& failed) {
  return error(Errc::io, "cannot listen on " + listen.address + ", port " + std::to_string(listen.port) + ": " +
                             failed.message());
}

}  // namespace

struct Server::Impl {
  struct Listener {
    // A strand: closing must not run at the same time as the accepting loop, which checks it between two connections.
    Listener(asio::io_context& io, bool operations, std::uint32_t most)
        : acceptor(asio::make_strand(io)), operations(operations), connections(most) {}
    tcp::acceptor acceptor;
    bool operations;
    ConnectionCounts connections;
  };
  struct Known {
    std::weak_ptr<Session> session;
    Listener* listener = nullptr;
    std::string address;  // the group for which it counts
  };

  Impl(ServerOptions given, const Backend& backend, Tokens tokens)
      : options(std::move(given)),
        front(backend, std::move(tokens), {options.public_url, options.hosts, options.sessions}),
        limits(limits_of(options)) {}
  Impl(ServerOptions given, const NodeHealth& node)
      : options(std::move(given)), front(node), limits(limits_of(options)) {}

  static SessionLimits limits_of(const ServerOptions& options) {
    return {.header = options.header_time,
            .idle = options.idle_time,
            .body = options.body_time,
            .write = options.write_time,
            .comment = options.comment_time};
  }

  Status listen(const ListenOptions& wanted);
  asio::awaitable<void> accept_all(Listener& listener);
  asio::awaitable<void> tell_refusals();
  void begin(tcp::socket socket, Listener& listener);
  void refuse(tcp::socket socket, const Listener& listener);
  void end(Session* session);
  std::shared_ptr<asio::ssl::context> current_tls() {
    const std::scoped_lock lock(mutex);
    return tls;
  }

  const ServerOptions options;
  Front front;
  const SessionLimits limits;
  std::mutex mutex;
  std::condition_variable ended;
  std::unordered_map<Session*, Known> sessions;
  std::shared_ptr<asio::ssl::context> tls;
  asio::io_context io;
  // Threads of points wait for batches. The more may wait, the larger are the batches.
  Workers workers{options.workers, {.usual = options.changes}, {.usual = options.questions}, {.usual = 16, .most = 48}};
  std::vector<std::unique_ptr<Listener>> listeners;
  std::vector<std::thread> threads;
};

Status Server::Impl::listen(const ListenOptions& wanted) {
  ErrorCode failed;
  const auto address = asio::ip::make_address(wanted.address, failed);
  if (failed) return error(Errc::usage, "listen: '" + wanted.address + "' is no address");
  if (!wanted.operations && !address.is_loopback() && !tls && !options.insecure)
    return error(Errc::usage, "listen: " + wanted.address +
                                  " can be reached from other machines; that needs a certificate and a key");
  const tcp::endpoint endpoint(address, wanted.port);
  const std::uint32_t most = wanted.operations ? options.health_connections : options.connections;
  const std::uint32_t within = connections_within(open_files_limit(), most);
  if (within < most)
    spdlog::warn("the limit of open files allows {} connections to port {}, not {}", within, wanted.port, most);
  auto listener = std::make_unique<Listener>(io, wanted.operations, within);
  listener->acceptor.open(endpoint.protocol(), failed);
  if (!failed) listener->acceptor.set_option(tcp::acceptor::reuse_address(true), failed);
  if (!failed) listener->acceptor.bind(endpoint, failed);
  if (!failed) listener->acceptor.listen(tcp::acceptor::max_listen_connections, failed);
  if (failed) return listen_error(wanted, failed);
  listeners.push_back(std::move(listener));
  return success();
}

asio::awaitable<void> Server::Impl::accept_all(Listener& listener) {
  bool told = false;
  while (listener.acceptor.is_open()) {
    ErrorCode error;
    const asio::any_io_executor strand = asio::make_strand(io);
    tcp::socket socket =
        co_await listener.acceptor.async_accept(strand, asio::redirect_error(asio::use_awaitable, error));
    if (!error) {
      told = false;
      begin(std::move(socket), listener);
    } else if (error != asio::error::operation_aborted) {
      // Mostly there are no descriptors left; some come back when connections end.
      if (!std::exchange(told, true)) spdlog::warn("cannot accept a connection: {}", error.message());
      asio::steady_timer timer(io, accept_again);
      co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, error));
    }
  }
}

asio::awaitable<void> Server::Impl::tell_refusals() {
  asio::steady_timer timer(co_await asio::this_coro::executor);
  while (true) {
    timer.expires_after(between_refusals);
    ErrorCode ended;
    co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, ended));
    if (ended) co_return;
    front.tell_refusals(RefusalLog::Clock::now());
  }
}

void Server::Impl::begin(tcp::socket socket, Listener& listener) {
  ErrorCode gone;
  const auto peer = socket.remote_endpoint(gone);
  if (gone) return;
  std::string address = group_of(peer.address());
  if (!listener.connections.take(address)) return refuse(std::move(socket), listener);
  const auto context = current_tls();
  auto transport =
      context && !listener.operations ? tls_transport(std::move(socket), context) : plain_transport(std::move(socket));
  auto session = std::make_shared<Session>(std::move(transport), front,
                                           listener.operations ? Place::operations : Place::api, limits, workers);
  Session* const key = session.get();
  {
    const std::scoped_lock lock(mutex);
    sessions.emplace(key, Known{session, &listener, std::move(address)});
  }
  const asio::any_io_executor executor = session->executor();
  asio::co_spawn(
      executor, [session = std::move(session)]() { return session->run(); },
      [this, key](std::exception_ptr failure) {
        end(key);
        if (!failure) return;
        try {
          std::rethrow_exception(failure);
        } catch (const std::exception& told) {
          spdlog::error("a connection ended: {}", told.what());
        }
      });
}

// Does not wait, because so short an answer always fits into a new socket. Under TLS no answer is possible without a
// handshake.
void Server::Impl::refuse(tcp::socket socket, const Listener& listener) {
  front.metrics().count_refused_connection();
  ErrorCode ignored;  // the peer may be gone already
  if (listener.operations || !current_tls()) {
    constexpr std::string_view answer =
        "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 5\r\nContent-Type: application/problem+json\r\n"
        "Content-Length: 65\r\nConnection: close\r\n\r\n"
        "{\"type\":\"about:blank\",\"title\":\"Service Unavailable\",\"status\":503}";
    socket.non_blocking(true, ignored);
    socket.send(asio::buffer(answer), 0, ignored);
    socket.shutdown(tcp::socket::shutdown_send, ignored);
    // Reads what has come: closing the socket with unread bytes would reset the connection, and lose the answer.
    std::array<char, 4096> unread{};
    socket.receive(asio::buffer(unread), 0, ignored);
  }
  socket.close(ignored);
}

void Server::Impl::end(Session* session) {
  const std::scoped_lock lock(mutex);
  const auto known = sessions.find(session);
  known->second.listener->connections.give_back(known->second.address);
  sessions.erase(known);
  if (sessions.empty()) ended.notify_all();
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() {
  impl_->io.stop();
  for (std::thread& thread : impl_->threads) thread.join();
  for (const auto& [key, known] : impl_->sessions)
    if (const auto session = known.session.lock()) session->stop_asking();
  impl_->workers.stop();
  impl_->workers.join();  // their work refers to sessions
  impl_->front.tell_refusals(RefusalLog::Clock::time_point::max());
}

Result<std::unique_ptr<Server>> Server::start(ServerOptions options, const Backend& backend) {
  if (options.listeners.empty()) return error(Errc::usage, "listen: no address is given");
  BOOST_OUTCOME_TRY(tokens, Tokens::open(options.tokens));
  auto impl = std::make_unique<Impl>(std::move(options), backend, std::move(tokens));
  std::unique_ptr<Server> server(new Server(std::move(impl)));
  BOOST_OUTCOME_TRYV(server->impl_->front.load_sessions());
  BOOST_OUTCOME_TRYV(server->reload());
  BOOST_OUTCOME_TRYV(server->listen());
  return server;
}

Result<std::unique_ptr<Server>> Server::start(ServerOptions options, const NodeHealth& node) {
  std::unique_ptr<Server> server(new Server(std::make_unique<Impl>(std::move(options), node)));
  BOOST_OUTCOME_TRYV(server->listen());
  return server;
}

Status Server::listen() {
  Impl& my = *impl_;
  for (const ListenOptions& listen : my.options.listeners) {
    BOOST_OUTCOME_TRYV(my.listen(listen));
  }
  for (const auto& listener : my.listeners)
    asio::co_spawn(listener->acceptor.get_executor(), my.accept_all(*listener), asio::detached);
  asio::co_spawn(my.io, my.tell_refusals(), asio::detached);
  for (std::uint32_t at = 0; at < std::max(1U, my.options.threads); ++at)
    my.threads.emplace_back([&my] {
      name_thread("http");
      my.io.run();
    });
  return success();
}

std::vector<std::uint16_t> Server::ports() const {
  std::vector<std::uint16_t> ports;
  for (const auto& listener : impl_->listeners) ports.push_back(listener->acceptor.local_endpoint().port());
  return ports;
}

std::string Server::token() const { return impl_->front.tokens().first(Role::admin); }

Status Server::reload() {
  const ServerOptions& options = impl_->options;
  // Tokens first: revoking a token must not wait for a valid certificate.
  BOOST_OUTCOME_TRY(tokens, Tokens::open(options.tokens, Tokens::Empty::allowed));
  const Status ended = impl_->front.replace_tokens(std::move(tokens));
  if (!options.certificate.empty()) {
    BOOST_OUTCOME_TRY(context, tls_context(options.certificate, options.key));
    const std::scoped_lock lock(impl_->mutex);
    impl_->tls = std::move(context);
  }
  return ended;
}

bool Server::drain(std::chrono::milliseconds time) {
  for (const auto& listener : impl_->listeners)
    asio::post(listener->acceptor.get_executor(), [&acceptor = listener->acceptor] {
      ErrorCode ignored;
      acceptor.close(ignored);
    });
  std::unique_lock lock(impl_->mutex);
  for (const auto& [key, known] : impl_->sessions)
    if (const auto session = known.session.lock()) session->drain();
  return impl_->ended.wait_for(lock, time, [&] { return impl_->sessions.empty(); });
}

}  // namespace tessera::service::http
