// A connection, plain or with TLS: reads bytes, writes bytes and files, and closes.
#pragma once

#include <utility>  // before awaitable.hpp of Boost 1.74, which forgets it

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

namespace tessera::service::http {

namespace asio = boost::asio;
using asio::ip::tcp;
using ErrorCode = boost::system::error_code;

// Call all functions on the socket's executor, which is a strand.
class Transport {
 public:
  virtual ~Transport() = default;
  virtual asio::awaitable<ErrorCode> handshake() = 0;
  // Returns 0 bytes with an error, also at the end.
  virtual asio::awaitable<std::size_t> read_some(asio::mutable_buffer buffer, ErrorCode& error) = 0;
  // `progress` is called whenever the peer has taken some bytes, here and below. The arguments must stay valid until
  // the operation ends.
  virtual asio::awaitable<ErrorCode> write(std::string_view head, std::string_view body,
                                           const std::function<void()>& progress) = 0;
  virtual asio::awaitable<ErrorCode> send_file(int file, std::uint64_t offset, std::uint64_t bytes,
                                               std::function<void()> progress) = 0;
  // Tells the peer that nothing more will come.
  virtual asio::awaitable<void> shut_down() = 0;
  virtual tcp::socket& socket() = 0;
  virtual bool is_tls() const = 0;
};

std::unique_ptr<Transport> plain_transport(tcp::socket socket);
std::unique_ptr<Transport> tls_transport(tcp::socket socket, std::shared_ptr<asio::ssl::context> context);

}  // namespace tessera::service::http
