// Asks a daemon whether it can take jobs. Containers and supervisors use this.
#pragma once

#include <string>

#include "src/base/result.h"

namespace tessera::daemon {

// Sends GET /readyz to `address` ("127.0.0.1:7071"), and waits at most five seconds for an answer. Success if the
// daemon is ready. Errors: usage for a malformed address; io if there is no answer, or with the daemon's reason why it
// is not ready.
Status check_health(const std::string& address);

}  // namespace tessera::daemon
