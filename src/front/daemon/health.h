// Asks a daemon whether it can take jobs: for containers and supervisors.
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera {

// GET /readyz at `address` ("127.0.0.1:7071"), silent for five seconds at most. Error usage for what is no address; io
// when nobody answers, or what the daemon says is missing.
Status check_health(const std::string& address);

}  // namespace tessera
