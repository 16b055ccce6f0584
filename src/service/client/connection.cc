#include "src/service/client/connection.h"

#include <utility>  // Boost 1.74's Asio needs it and does not include it
//
#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace tessera::client {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using boost::system::error_code;

namespace {

constexpr std::chrono::seconds connect_patience{10};
constexpr std::size_t body_bytes_max = std::size_t{64} << 20;  // of a body that is kept in memory
constexpr std::uint32_t header_bytes_max = 64 << 10;

std::string lower_case(std::string text) {
  for (auto& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

HttpHead head_of(const http::response<http::buffer_body>& message) {
  HttpHead head;
  head.status = static_cast<int>(message.result_int());
  for (const auto& field : message) {
    head.headers.insert_or_assign(lower_case(std::string(field.name_string())), std::string(field.value()));
  }
  return head;
}

}  // namespace

const std::string& HttpHead::header(const std::string& name) const {
  static const std::string none;
  const auto found = headers.find(name);
  return found == headers.end() ? none : found->second;
}

using Secure = beast::ssl_stream<beast::tcp_stream>;
using Completed = std::function<void(error_code, std::size_t)>;

// A stream of one of two types, with one type of handler. So Beast's composed operations are compiled once, and not for
// each stream and handler.
class AnyStream {
 public:
  using executor_type = beast::tcp_stream::executor_type;

  AnyStream(std::optional<beast::tcp_stream>& plain, std::optional<Secure>& secure) : plain_(plain), secure_(secure) {}
  executor_type get_executor() { return secure_ ? secure_->get_executor() : plain_->get_executor(); }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    read_some(
        std::vector<asio::mutable_buffer>(asio::buffer_sequence_begin(buffers), asio::buffer_sequence_end(buffers)),
        erased(std::forward<Handler>(handler)));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    write_some(
        std::vector<asio::const_buffer>(asio::buffer_sequence_begin(buffers), asio::buffer_sequence_end(buffers)),
        erased(std::forward<Handler>(handler)));
  }

 private:
  // Handlers can only be moved, but std::function must be copyable.
  template <class Handler>
  static Completed erased(Handler&& handler) {
    auto held = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return [held](error_code code, std::size_t bytes) { std::move (*held)(code, bytes); };
  }
  void read_some(const std::vector<asio::mutable_buffer>& buffers, Completed done) {
    if (secure_) {
      secure_->async_read_some(buffers, std::move(done));
    } else {
      plain_->async_read_some(buffers, std::move(done));
    }
  }
  void write_some(const std::vector<asio::const_buffer>& buffers, Completed done) {
    if (secure_) {
      secure_->async_write_some(buffers, std::move(done));
    } else {
      plain_->async_write_some(buffers, std::move(done));
    }
  }

  std::optional<beast::tcp_stream>& plain_;
  std::optional<Secure>& secure_;
};

struct Connection::Impl {
  using Parser = http::response_parser<http::buffer_body>;

  ServerAddress address;
  asio::io_context context{1};
  asio::ssl::context tls{asio::ssl::context::tls_client};
  asio::ip::tcp::resolver resolver{context};
  std::optional<beast::tcp_stream> plain;  // when it is open
  std::optional<Secure> secure;
  AnyStream stream{plain, secure};
  beast::flat_buffer buffer;

  bool is_open() const { return plain.has_value() || secure.has_value(); }
  void close() {
    plain.reset();
    secure.reset();
    buffer.clear();
  }
  beast::tcp_stream& lowest() { return secure ? secure->next_layer() : *plain; }

  // Runs one asynchronous operation to its end. `cancel` ends it early.
  error_code complete(const std::stop_token& stop, const std::function<void(Completed)>& start,
                      const std::function<void()>& cancel) {
    error_code result;
    context.restart();
    start([&result](error_code code, std::size_t) { result = code; });
    const std::stop_callback on_stop(stop, [&] { asio::post(context, cancel); });
    context.run();
    return result;
  }
  error_code on_stream(const std::stop_token& stop, std::chrono::seconds silence,
                       const std::function<void(Completed)>& start) {
    lowest().expires_after(silence);
    return complete(stop, start, [this] {
      if (is_open()) lowest().cancel();
    });
  }

  Error failed(const std::stop_token& stop, const error_code& code, const std::string& what) const {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted");
    const auto reason = code == beast::error::timeout ? std::string("it does not answer in time") : code.message();
    return error(Errc::io, address.text() + ": " + what + ": " + reason);
  }

  Status connect(const std::stop_token& stop) {
    asio::ip::tcp::resolver::results_type found;
    const auto resolved = complete(
        stop,
        [&](Completed done) {
          resolver.async_resolve(address.host, address.port, asio::ip::resolver_base::numeric_service,
                                 [&found, done](error_code code, auto results) mutable {
                                   found = results;
                                   done(code, 0);
                                 });
        },
        [this] { resolver.cancel(); });
    if (resolved) return failed(stop, resolved, "there is no host of this name");
    if (address.tls) {
      secure.emplace(context, tls);
    } else {
      plain.emplace(context);
    }
    lowest().expires_after(connect_patience);
    const auto connected = complete(
        stop,
        [&](Completed done) { lowest().async_connect(found, [done](error_code code, const auto&) { done(code, 0); }); },
        [this] { lowest().cancel(); });
    if (connected) return failed(stop, connected, "no server can be reached there");
    error_code ignored;
    lowest().socket().set_option(asio::ip::tcp::no_delay(true), ignored);
    return address.tls ? shake_hands(stop) : success();
  }

  Status shake_hands(const std::stop_token& stop) {
    error_code not_an_address;
    asio::ip::make_address(address.host, not_an_address);
    if (not_an_address) SSL_set_tlsext_host_name(secure->native_handle(), address.host.c_str());
    secure->set_verify_callback(asio::ssl::host_name_verification(address.host));
    const auto shaken = on_stream(stop, connect_patience, [this](Completed done) {
      secure->async_handshake(asio::ssl::stream_base::client, [done](error_code code) { done(code, 0); });
    });
    if (!shaken) return success();
    const auto verified = SSL_get_verify_result(secure->native_handle());
    if (verified != X509_V_OK) {
      return error(Errc::usage, address.text() + ": the certificate of the server is not trusted: " +
                                    X509_verify_cert_error_string(verified));
    }
    if (shaken.category() == asio::error::get_ssl_category() && !stop.stop_requested()) {
      const auto* reason = ERR_reason_error_string(static_cast<unsigned long>(shaken.value()));
      return error(Errc::usage,
                   address.text() + ": the server does not speak TLS: " + (reason ? reason : shaken.message()));
    }
    return failed(stop, shaken, "the connection cannot be secured");
  }

  template <class Message>
  void set_head(Message& message, const HttpRequest& request) const {
    message.version(11);
    message.method_string(request.method);
    message.target(request.target);
    message.set(http::field::host, address.authority());
    message.set(http::field::user_agent, "tessera");
    for (const auto& [name, value] : request.headers) message.set(name, value);
  }

  error_code send(const HttpRequest& request, const std::stop_token& stop) {
    http::request<http::string_body> message;
    set_head(message, request);
    message.body() = request.body;
    message.prepare_payload();
    return on_stream(stop, request.silence,
                     [&](Completed done) { http::async_write(stream, message, std::move(done)); });
  }

  // Ends early when the server sends something. `left` is the number of bytes that were not sent.
  Result<error_code> send_from_source(const HttpRequest& request, const std::stop_token& stop, std::uint64_t& left) {
    http::request<http::buffer_body> message;
    set_head(message, request);
    message.content_length(request.source_bytes);
    message.body().data = nullptr;
    message.body().more = true;
    http::request_serializer<http::buffer_body> serializer(message);
    auto code = on_stream(stop, request.silence,
                          [&](Completed done) { http::async_write_header(stream, serializer, std::move(done)); });
    std::vector<char> bytes(std::size_t{256} << 10);
    for (left = request.source_bytes; left > 0 && !code;) {
      error_code unknown;
      // Under TLS bytes always come, and they need not be an answer.
      if (plain && plain->socket().available(unknown) > 0) break;
      BOOST_OUTCOME_TRY(piece, request.source(std::span(bytes).first(std::min<std::uint64_t>(bytes.size(), left))));
      left -= piece;
      message.body().data = bytes.data();
      message.body().size = piece;
      message.body().more = left > 0;
      code = on_stream(stop, request.silence,
                       [&](Completed done) { http::async_write(stream, serializer, std::move(done)); });
      if (code == http::error::need_buffer) code = {};
    }
    return code;
  }

  Result<HttpAnswer> exchange(const HttpRequest& request, const std::stop_token& stop, const HttpReceiver& receiver,
                              bool& answered) {
    std::uint64_t unsent = 0;
    error_code written;
    if (request.source) {
      BOOST_OUTCOME_TRY(sent, send_from_source(request, stop, unsent));
      written = sent;
    } else {
      written = send(request, stop);
    }
    // A server that refuses a request may answer before all of it was sent.
    Parser parser;
    parser.skip(request.method == "HEAD");
    // Boost 1.74 takes `none` as a limit below every length.
    parser.body_limit(std::numeric_limits<std::uint64_t>::max());
    parser.header_limit(header_bytes_max);
    const auto read_head = on_stream(stop, request.silence, [&](Completed done) {
      http::async_read_header(stream, buffer, parser, std::move(done));
    });
    if (read_head) {
      if (read_head.category() == make_error_code(http::error::bad_version).category() &&
          read_head != http::error::end_of_stream && read_head != http::error::partial_message)
        return error(Errc::usage, address.text() + ": the server does not speak HTTP");
      return failed(stop, written ? written : read_head, "the server has ended the connection");
    }
    answered = true;
    HttpAnswer answer;
    static_cast<HttpHead&>(answer) = head_of(parser.get());
    bool taken = false;
    if (receiver.head) {
      BOOST_OUTCOME_TRY(wanted, receiver.head(answer));
      taken = wanted;
    }
    std::array<char, std::size_t{64} << 10> bytes;
    while (!parser.is_done()) {
      parser.get().body().data = bytes.data();
      parser.get().body().size = bytes.size();
      auto code = on_stream(stop, request.silence,
                            [&](Completed done) { http::async_read_some(stream, buffer, parser, std::move(done)); });
      if (code == http::error::need_buffer) code = {};
      const std::string_view part(bytes.data(), bytes.size() - parser.get().body().size);
      if (taken) {
        BOOST_OUTCOME_TRYV(receiver.body(part));
      } else {
        answer.body += part;
        if (answer.body.size() > body_bytes_max)
          return error(Errc::io, address.text() + ": the server's answer is longer than " +
                                     std::to_string(body_bytes_max >> 20) + " MiB");
      }
      if (code) return failed(stop, code, "the server has ended the connection within its answer");
    }
    if (!parser.get().keep_alive() || unsent > 0) close();
    return answer;
  }
};

Connection::Connection(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Connection::Connection(Connection&&) noexcept = default;
Connection::~Connection() = default;

Result<Connection> Connection::make(ServerAddress address, const std::filesystem::path& authorities) {
  auto impl = std::make_unique<Impl>();
  impl->address = std::move(address);
  error_code code;
  impl->tls.set_verify_mode(asio::ssl::verify_peer, code);
  if (authorities.empty()) {
    impl->tls.set_default_verify_paths(code);
  } else {
    impl->tls.load_verify_file(authorities.string(), code);
    if (code) return error(Errc::io, authorities.string() + ": holds no certificates that can be read");
  }
  return Connection(std::move(impl));
}

Result<HttpAnswer> Connection::ask(const HttpRequest& request, const std::stop_token& stop,
                                   const HttpReceiver& receiver) {
  if (!request.repeatable) impl_->close();
  while (true) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted");
    const bool kept = impl_->is_open();
    bool answered = false;
    if (!kept) {
      const auto connected = impl_->connect(stop);
      if (!connected) {
        impl_->close();
        return connected.error();
      }
    }
    auto answer = impl_->exchange(request, stop, receiver, answered);
    if (answer) return answer;
    impl_->close();
    // The server may close a kept connection at any time.
    if (!kept || answered || answer.error().code != Errc::io) return answer;
  }
}

}  // namespace tessera::client
