// A request while a session reads it.
#pragma once

#include "src/service/http/session.h"

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <cstdint>
#include <optional>

namespace tessera::service::http {

struct Session::Incoming {
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser;
  Request request;
  Admitted admitted;
  std::optional<std::uint64_t> length;
  std::optional<Turns::QueueSlot> slot;  // where callers take turns: held until the request is answered
  bool chunked = false, keep_alive = false, head = false, expects_continue = false;

  bool has_body() const { return chunked || length.value_or(0) > 0; }
};

}  // namespace tessera::service::http
