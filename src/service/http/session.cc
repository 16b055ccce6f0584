#include "src/service/http/session.h"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "src/service/http/head.h"
#include "src/service/http/incoming.h"

namespace tessera::service::http {
namespace {

namespace beast = boost::beast;
using asio::redirect_error;
using asio::use_awaitable;

constexpr std::size_t read_bytes = 8 << 10;
constexpr std::size_t lingering_max = 64 << 20;  // the sender of a refused upload may see the answer only at its end
constexpr std::chrono::milliseconds lingering{2000};

std::string lower_case(beast::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  return lower;
}

// Obsolete line folding (RFC 9112, 5.2), which Beast accepts.
bool has_folded_line(std::string_view header) {
  for (std::size_t end = header.find('\n'); end != std::string_view::npos; end = header.find('\n', end + 1))
    if (end + 1 < header.size() && (header[end + 1] == ' ' || header[end + 1] == '\t')) return true;
  return false;
}

}  // namespace

Session::Session(std::unique_ptr<Transport> transport, Front& front, Place place, const SessionLimits& limits,
                 Workers& workers)
    : transport_(std::move(transport)),
      front_(front),
      place_(place),
      limits_(limits),
      workers_(workers),
      time_(transport_->socket().get_executor()) {
  front_.metrics().add_connections(1);
}

Session::~Session() { front_.metrics().add_connections(-1); }

void Session::give_up_after(std::chrono::milliseconds time) {
  deadline_ = std::chrono::steady_clock::now() + time;
  if (deadline_ < time_.expiry()) time_.expires_at(deadline_);  // wakes watch_time(), which then waits anew
}

asio::awaitable<void> Session::watch_time() {
  while (open_) {
    ErrorCode changed;
    if (deadline_ > time_.expiry() || time_.expiry() <= std::chrono::steady_clock::now()) time_.expires_at(deadline_);
    co_await time_.async_wait(redirect_error(use_awaitable, changed));
    if (open_ && std::chrono::steady_clock::now() >= deadline_) {
      open_ = false;
      ErrorCode ignored;  // all operations on the socket end with an error
      transport_->socket().close(ignored);
    }
  }
}

asio::awaitable<void> Session::run() {
  const std::shared_ptr<Session> self = shared_from_this();
  ErrorCode error;
  const auto peer = transport_->socket().remote_endpoint(error);
  if (!error) remote_ = peer.address().to_string();
  const auto local = transport_->socket().local_endpoint(error);
  if (!error) port_ = local.port();
  time_.expires_at(std::chrono::steady_clock::time_point::max());
  give_up_after(limits_.header);
  asio::co_spawn(
      transport_->socket().get_executor(), [self]() { return self->watch_time(); }, asio::detached);
  idle_ = false;
  error = co_await transport_->handshake();
  bool more = !error;
  while (more) more = co_await serve_one();
  if (open_ && !error) {
    give_up_after(lingering);
    co_await transport_->shut_down();
    if (unread_) co_await linger();
  }
  open_ = false;
  time_.cancel();
  ErrorCode ignored;
  transport_->socket().close(ignored);
}

void Session::drain() {
  asio::post(transport_->socket().get_executor(), [weak = weak_from_this()] {
    const std::shared_ptr<Session> self = weak.lock();
    if (!self) return;
    self->draining_ = true;
    if (self->events_) self->events_->end();
    if (!self->idle_) return;
    self->open_ = false;
    ErrorCode ignored;
    self->transport_->socket().close(ignored);
    self->time_.cancel();
  });
}

asio::awaitable<ErrorCode> Session::read_more() {
  ErrorCode error;
  const asio::mutable_buffer space = buffer_.prepare(read_bytes);
  const std::size_t bytes = co_await transport_->read_some(space, error);
  buffer_.commit(bytes);
  co_return error;
}

asio::awaitable<bool> Session::serve_one() {
  Incoming incoming;
  bool whole = co_await read_header(incoming);
  if (!whole) co_return false;
  if (incoming.admitted.answer) {
    Answer refused = std::move(*incoming.admitted.answer);
    unread_ = unread_ || incoming.has_body() || refused.close;
    co_return co_await send(incoming, std::move(refused));
  }
  if (incoming.admitted.route->upload) co_return co_await take_upload(incoming);
  if (incoming.has_body()) {
    whole = co_await read_body(incoming);
    if (!whole) co_return false;
  }
  Answer answered = co_await answer(incoming);
  co_return co_await send(incoming, std::move(answered));
}

asio::awaitable<Answer> Session::answer(Incoming& incoming) {
  const Runs runs = incoming.admitted.route->runs;
  if (runs == Runs::at_once) co_return front_.answer(incoming.request, incoming.admitted);
  never_give_up();
  Request& request = incoming.request;
  if (in_turn(runs)) {
    asked_ = std::make_shared<WatchedWork>(
        transport_, runs == Runs::changes ? std::optional(limits_.work) : std::optional<std::chrono::milliseconds>());
    request.stop = request.caller.stop = asked_->token();
    asked_->watch();
  }
  const auto work = [&] {
    if (asked_) asked_->begin();
    return front_.answer(request, incoming.admitted);
  };
  const auto post = [&](auto task) {
    if (in_turn(runs))
      turns(runs).post(request.caller.name, std::move(task));
    else
      asio::post(runs == Runs::health ? workers_.health : workers_.disk, std::move(task));
  };
  std::optional<Answer> answered = co_await on_worker(post, work);
  incoming.slot.reset();
  asked_.reset();
  co_return std::move(*answered);
}

std::optional<Answer> Session::refused_by_header(const Incoming& incoming, bool folded, const std::string& expect,
                                                 unsigned version, std::uint64_t body_bytes) {
  const Admitted& admitted = incoming.admitted;
  const auto encoding = incoming.request.header("transfer-encoding");
  // Beast takes a body in any other encoding for none, and what follows for the next request.
  if (!encoding.empty() && encoding != "chunked") return problem(501, "Transfer-Encoding: only chunked is supported");
  // What stands before this service may read it as a header of its own.
  if (folded) return problem(400, "a line of the header begins with a space or a tab");
  if (version != 11 && version != 10) return problem(400, "only HTTP/1.1 and HTTP/1.0 are supported");
  if (!expect.empty() && !incoming.expects_continue) return problem(417, "Expect: only 100-continue is supported");
  if (admitted.answer) return std::nullopt;
  if (!admitted.route->upload && incoming.length.value_or(0) > body_bytes)
    return problem(413, "the body is larger than " + std::to_string(body_bytes) + " bytes");
  if (admitted.route->upload && (incoming.chunked || !incoming.length)) return problem(411, "Content-Length is needed");
  return std::nullopt;
}

asio::awaitable<bool> Session::read_header(Incoming& incoming) {
  auto& parser = incoming.parser.emplace();
  parser.header_limit(limits_.header_bytes);
  parser.body_limit(std::numeric_limits<std::uint64_t>::max());  // too long a body is refused when the caller is known
  ErrorCode error;
  if (buffer_.size() == 0) {
    if (draining_) co_return false;
    buffer_.shrink_to_fit();
    idle_ = true;
    give_up_after(limits_.idle);
    error = co_await read_more();
    idle_ = false;
    if (error) co_return false;
  }
  bool folded = false;
  for (bool timed = false;; timed = true) {
    const std::size_t used = parser.put(buffer_.data(), error);
    // All bytes at once, when all are there.
    folded = folded || has_folded_line({static_cast<const char*>(buffer_.data().data()), used});
    buffer_.consume(used);
    if (!error && parser.is_header_done()) break;
    if (error && error != beast::http::error::need_more) {
      unread_ = true;
      const bool large = error == beast::http::error::header_limit;
      incoming.admitted.began = std::chrono::steady_clock::now();
      Answer refused =
          large ? problem(431, "the header is larger than " + std::to_string(limits_.header_bytes) + " bytes")
                : problem(400, "this is no HTTP request: " + error.message());
      co_await send(incoming, std::move(refused));
      co_return false;
    }
    if (!timed) give_up_after(limits_.header);
    error = co_await read_more();
    if (error) co_return false;
  }
  const auto& message = parser.get();
  Request& request = incoming.request;
  request.method = std::string(message.method_string());
  for (const auto& field : message)
    request.headers.emplace_back(lower_case(field.name_string()), std::string(field.value()));
  request.remote = remote_;
  request.port = port_;
  request.tls = transport_->is_tls();
  incoming.keep_alive = parser.keep_alive();
  incoming.head = request.method == "HEAD";
  incoming.chunked = parser.chunked();
  if (const auto length = parser.content_length()) incoming.length = *length;
  const std::string expect =
      lower_case(beast::string_view(request.header("expect").data(), request.header("expect").size()));
  incoming.expects_continue = expect == "100-continue";
  incoming.admitted = front_.admit(request, std::string_view(message.target().data(), message.target().size()), place_);
  Admitted& admitted = incoming.admitted;
  const auto encoding = request.header("transfer-encoding");
  if (folded || (!encoding.empty() && encoding != "chunked")) {  // where the next request begins is not certain
    incoming.keep_alive = false;
    unread_ = true;
  }
  if (auto refused = refused_by_header(incoming, folded, expect, message.version(), limits_.body_bytes))
    admitted.answer = std::move(*refused);
  if (!admitted.answer) admitted.answer = take_slot(incoming);
  give_up_after(limits_.body);
  if (!admitted.answer && incoming.expects_continue && incoming.has_body() && buffer_.size() == 0) {
    const std::function<void()> no_matter = [] {};
    error = co_await transport_->write("HTTP/1.1 100 Continue\r\n\r\n", {}, no_matter);
    if (error) co_return false;
  }
  co_return true;
}

asio::awaitable<bool> Session::send(Incoming& incoming, Answer answer) {
  front_.complete(incoming.request, incoming.admitted, answer);
  const bool keep = incoming.keep_alive && !answer.close && !draining_ && !unread_;
  const std::string head = head_of(answer, keep);
  const bool bare = incoming.head || has_no_body(answer.status);
  const std::function<void()> progress = [this] { give_up_after(limits_.write); };  // a slow reader is not a dead one
  progress();
  ErrorCode error = co_await transport_->write(
      head, bare || answer.file || answer.events ? std::string_view() : answer.body, progress);
  if (!error && !bare && answer.file)
    error = co_await transport_->send_file(answer.file->file.get(), answer.file->offset, answer.file->bytes, progress);
  if (!error && !bare && answer.events) {
    events_ = std::make_shared<EventSender>(transport_, answer.events, limits_,
                                            [this](std::chrono::milliseconds time) { give_up_after(time); });
    if (draining_) events_->end();
    error = co_await events_->run();
    events_.reset();
  }
  co_return keep && !error;
}

// If a connection is closed with unread bytes, it is reset and the peer loses the answer. So bytes that the peer still
// sends are read and dropped for a while.
asio::awaitable<void> Session::linger() {
  ErrorCode error;
  for (std::size_t bytes = 0; !error && bytes < lingering_max;) {
    buffer_.clear();
    const asio::mutable_buffer space = buffer_.prepare(read_bytes);
    bytes += co_await transport_->read_some(space, error);
  }
}

}  // namespace tessera::service::http
