// The error of an option of a process that cannot be used.
#pragma once

#include <string>

#include "src/base/option.h"
#include "src/base/result.h"

namespace tessera::service {

inline Error refuse(const char* key, const std::string& reason) {
  return error(Errc::usage, option(key) + ": " + reason);
}

}  // namespace tessera::service
