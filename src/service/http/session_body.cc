#include "src/service/http/incoming.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/beast/http/string_body.hpp>
#include <utility>

namespace tessera::service::http {
namespace {

namespace beast = boost::beast;
constexpr std::size_t buffered_max = 64 << 10, upload_piece = 256 << 10;

}  // namespace

// Takes a slot of the queue for the request. Returns the reason as an answer when there is none.
std::optional<Answer> Session::take_slot(Incoming& incoming) {
  const Runs runs = incoming.admitted.route->runs;
  if (!in_turn(runs)) return std::nullopt;
  auto slot = turns(runs).enter(incoming.request.caller.name,
                                incoming.chunked ? limits_.body_bytes : incoming.length.value_or(0));
  if (slot) {
    incoming.slot.emplace(std::move(*slot));
    return std::nullopt;
  }
  return problem(503, "too many requests wait already, with this token or in all");
}

asio::awaitable<bool> Session::read_body(Incoming& incoming) {
  beast::http::request_parser<beast::http::string_body> parser(std::move(*incoming.parser));
  parser.body_limit(limits_.body_bytes);
  parser.eager(true);
  give_up_after(limits_.body);
  while (!parser.is_done()) {
    ErrorCode error;
    const std::size_t used = parser.put(buffer_.data(), error);
    buffer_.consume(used);
    if (parser.is_done()) break;
    const bool needs_more = error == beast::http::error::need_more || (!error && used == 0);
    if ((error && !needs_more) || buffer_.size() > buffered_max) {
      unread_ = true;
      const bool large = error == beast::http::error::body_limit;
      Answer refused = large ? problem(413, "the body is larger than " + std::to_string(limits_.body_bytes) + " bytes")
                             : problem(400, "the chunks of the body are not as HTTP defines them");
      co_await send(incoming, std::move(refused));
      co_return false;
    }
    if (needs_more || buffer_.size() == 0) {
      error = co_await read_more();
      if (error) co_return false;
    }
  }
  incoming.request.body = std::move(parser.get().body());
  co_return true;
}

asio::awaitable<bool> Session::take_upload(Incoming& incoming) {
  never_give_up();
  const auto begin = [&] { return front_.begin_upload(incoming.request, incoming.admitted); };
  const auto post = [this](auto task) { asio::post(workers_.disk, std::move(task)); };
  auto begun = co_await on_worker(post, begin);
  auto& upload = *begun;
  std::uint64_t left = *incoming.length;
  unread_ = true;
  if (!upload) {
    Answer refused = problem(upload.error());
    co_return co_await send(incoming, std::move(refused));
  }
  while (left > 0) {
    if (buffer_.size() == 0) {
      give_up_after(limits_.body);
      const asio::mutable_buffer space = buffer_.prepare(std::min<std::uint64_t>(left, upload_piece));
      ErrorCode error;
      const std::size_t bytes = co_await transport_->read_some(space, error);
      buffer_.commit(bytes);
      if (error) co_return false;
    }
    const std::size_t bytes = std::min<std::uint64_t>(left, buffer_.size());
    never_give_up();
    const auto write = [&] {
      return upload.value()->write(std::string_view(static_cast<const char*>(buffer_.data().data()), bytes));
    };
    const auto written = co_await on_worker(post, write);
    if (!*written) {
      Answer refused = problem(written->error());
      co_return co_await send(incoming, std::move(refused));
    }
    buffer_.consume(bytes);
    left -= bytes;
  }
  unread_ = false;
  never_give_up();
  const auto finish = [&] { return upload.value()->finish(); };
  const auto finished = co_await on_worker(post, finish);
  if (!*finished) {
    Answer refused = problem(finished->error());
    co_return co_await send(incoming, std::move(refused));
  }
  Answer taken = front_.answer(incoming.request, incoming.admitted);
  co_return co_await send(incoming, std::move(taken));
}

}  // namespace tessera::service::http
