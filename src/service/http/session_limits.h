// Limits of one connection.
#pragma once

#include <chrono>
#include <cstdint>

namespace tessera::service::http {

struct SessionLimits {
  std::uint32_t header_bytes = 8 << 10;
  std::uint64_t body_bytes = 1 << 20;  // without uploads
  // `write` is the time without any progress; `work` is for requests that take turns, except questions, which have
  // bounds of their own.
  std::chrono::milliseconds header{10'000}, idle{60'000}, body{30'000}, write{30'000}, comment{15'000}, work{60'000};
};

}  // namespace tessera::service::http
