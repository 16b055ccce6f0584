#include "src/service/http/transport.h"

#include <sys/sendfile.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <vector>

namespace tessera::service::http {
namespace {

using asio::redirect_error;
using asio::use_awaitable;

constexpr std::size_t piece_bytes = 1 << 20, copied_bytes = 1 << 17;
constexpr int pieces_in_a_row = 8;  // then other connections get their turn

ErrorCode system_error(int number) { return {number, boost::system::system_category()}; }

// Like asio::transfer_all(), and calls `progress` whenever bytes were taken.
auto until_all(const std::function<void()>& progress) {
  constexpr std::size_t piece = 1 << 16;  // as in asio::transfer_all()
  return [&progress](const ErrorCode& error, std::size_t) -> std::size_t {
    if (error) return 0;
    progress();
    return piece;
  };
}

class Plain final : public Transport {
 public:
  explicit Plain(tcp::socket socket) : socket_(std::move(socket)) {}

  asio::awaitable<ErrorCode> handshake() override {
    ErrorCode error;
    socket_.non_blocking(true, error);
    if (!error) socket_.set_option(tcp::no_delay(true), error);
    co_return error;
  }

  asio::awaitable<std::size_t> read_some(asio::mutable_buffer buffer, ErrorCode& error) override {
    const std::size_t bytes = co_await socket_.async_read_some(buffer, redirect_error(use_awaitable, error));
    co_return bytes;
  }

  asio::awaitable<ErrorCode> write(std::string_view head, std::string_view body,
                                   const std::function<void()>& progress) override {
    ErrorCode error;
    const std::array<asio::const_buffer, 2> both{asio::buffer(head), asio::buffer(body)};
    co_await asio::async_write(socket_, both, until_all(progress), redirect_error(use_awaitable, error));
    co_return error;
  }

  // Sends from the page cache to the socket, without copying the bytes to this process.
  asio::awaitable<ErrorCode> send_file(int file, std::uint64_t offset, std::uint64_t bytes,
                                       std::function<void()> progress) override {
    ErrorCode error;
    auto at = static_cast<off_t>(offset);
    int pieces = 0;
    while (bytes > 0 && !error) {
      const ssize_t sent = ::sendfile(socket_.native_handle(), file, &at, std::min<std::uint64_t>(bytes, piece_bytes));
      if (sent > 0) {
        bytes -= static_cast<std::uint64_t>(sent);
        progress();
        if (++pieces % pieces_in_a_row == 0) co_await asio::post(socket_.get_executor(), use_awaitable);
      } else if (sent == 0) {
        error = asio::error::eof;  // the file has become shorter
      } else if (errno == EAGAIN) {
        co_await socket_.async_wait(tcp::socket::wait_write, redirect_error(use_awaitable, error));
      } else if (errno != EINTR) {
        error = system_error(errno);
      }
    }
    co_return error;
  }

  asio::awaitable<void> shut_down() override {
    ErrorCode ignored;  // the peer may have gone first
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
    co_return;
  }

  tcp::socket& socket() override { return socket_; }
  bool is_tls() const override { return false; }

 private:
  tcp::socket socket_;
};

class Tls final : public Transport {
 public:
  Tls(tcp::socket socket, std::shared_ptr<asio::ssl::context> context)
      : context_(std::move(context)), stream_(std::move(socket), *context_) {
    SSL_set_mode(stream_.native_handle(), SSL_MODE_RELEASE_BUFFERS);  // an idle connection needs no buffers
  }

  asio::awaitable<ErrorCode> handshake() override {
    ErrorCode error;
    socket().set_option(tcp::no_delay(true), error);
    if (!error) co_await stream_.async_handshake(asio::ssl::stream_base::server, redirect_error(use_awaitable, error));
    co_return error;
  }

  asio::awaitable<std::size_t> read_some(asio::mutable_buffer buffer, ErrorCode& error) override {
    const std::size_t bytes = co_await stream_.async_read_some(buffer, redirect_error(use_awaitable, error));
    co_return bytes;
  }

  asio::awaitable<ErrorCode> write(std::string_view head, std::string_view body,
                                   const std::function<void()>& progress) override {
    ErrorCode error;
    const std::array<asio::const_buffer, 2> both{asio::buffer(head), asio::buffer(body)};
    co_await asio::async_write(stream_, both, until_all(progress), redirect_error(use_awaitable, error));
    co_return error;
  }

  asio::awaitable<ErrorCode> send_file(int file, std::uint64_t offset, std::uint64_t bytes,
                                       std::function<void()> progress) override {
    ErrorCode error;
    std::vector<char> piece(std::min<std::uint64_t>(bytes, copied_bytes));
    while (bytes > 0 && !error) {
      const ssize_t got =
          ::pread(file, piece.data(), std::min<std::uint64_t>(bytes, piece.size()), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) co_return got == 0 ? ErrorCode(asio::error::eof) : system_error(errno);
      const asio::const_buffer read = asio::buffer(piece.data(), static_cast<std::size_t>(got));
      co_await asio::async_write(stream_, read, redirect_error(use_awaitable, error));
      offset += static_cast<std::uint64_t>(got);
      bytes -= static_cast<std::uint64_t>(got);
      progress();
    }
    co_return error;
  }

  asio::awaitable<void> shut_down() override {
    ErrorCode ignored;  // many peers do not wait for it
    co_await stream_.async_shutdown(redirect_error(use_awaitable, ignored));
  }

  tcp::socket& socket() override { return stream_.next_layer(); }
  bool is_tls() const override { return true; }

 private:
  std::shared_ptr<asio::ssl::context> context_;
  asio::ssl::stream<tcp::socket> stream_;
};

}  // namespace

std::unique_ptr<Transport> plain_transport(tcp::socket socket) { return std::make_unique<Plain>(std::move(socket)); }

std::unique_ptr<Transport> tls_transport(tcp::socket socket, std::shared_ptr<asio::ssl::context> context) {
  return std::make_unique<Tls>(std::move(socket), std::move(context));
}

}  // namespace tessera::service::http
