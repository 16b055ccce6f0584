#include "src/daemon/health.h"

#include <boost/asio/ip/address.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>

#include "src/daemon/daemon_options.h"

namespace tessera {

Status check_health(const std::string& address) {
  namespace asio = boost::asio;
  namespace beast = boost::beast;
  BOOST_OUTCOME_TRY(where, parse_address(address));
  boost::system::error_code ec;
  const auto ip = asio::ip::make_address(where.address, ec);
  if (ec) return error(Errc::usage, "'" + address + "' is no address like 127.0.0.1:7071");

  asio::io_context context;
  beast::tcp_stream stream(context);
  stream.expires_after(std::chrono::seconds(5));
  beast::flat_buffer buffer;
  beast::http::response<beast::http::string_body> answer;
  beast::http::request<beast::http::empty_body> request(beast::http::verb::get, "/readyz?verbose", 11);
  request.set(beast::http::field::host, address);
  // One after the other; each step only once the one before has succeeded.
  stream.async_connect(asio::ip::tcp::endpoint(ip, where.port), [&](beast::error_code failed) {
    if ((ec = failed)) return;
    beast::http::async_write(stream, request, [&](beast::error_code not_written, std::size_t) {
      if ((ec = not_written)) return;
      beast::http::async_read(stream, buffer, answer, [&](beast::error_code not_read, std::size_t) { ec = not_read; });
    });
  });
  context.run();
  if (ec) return error(Errc::io, address + ": " + ec.message());
  if (answer.result() == beast::http::status::ok) return success();
  return error(Errc::io, address + ": not ready: " + answer.body());
}

}  // namespace tessera
