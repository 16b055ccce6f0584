// Who asks the service.
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>

namespace tessera::service {

// What a caller may do. Each role includes the ones before.
enum class Role : std::uint8_t { none, read, submit, admin };

struct Caller {
  std::string name;  // of the token
  Role role = Role::none;
  std::stop_token stop = {};  // stopped when the caller has gone or has waited too long
};

}  // namespace tessera::service
