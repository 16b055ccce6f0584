// The first lines of an answer.
#pragma once

#include <string>

#include "src/service/http/message.h"

namespace tessera::http {

// Whether an answer of that status ends with its header.
inline bool has_no_body(int status) { return status == 204 || status == 304; }

// Up to the empty line. `keep`: whether the connection goes on.
std::string head_of(const Answer& answer, bool keep);

}  // namespace tessera::http
