// Writes the status line and the header of an answer.
#pragma once

#include <string>

#include "src/service/http/message.h"

namespace tessera::service::http {

// True if an answer with this status has no body.
inline bool has_no_body(int status) { return status == 204 || status == 304; }

// All lines up to the empty one. `keep`: the connection stays open.
std::string head_of(const Answer& answer, bool keep);

}  // namespace tessera::service::http
