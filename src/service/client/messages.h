// Parses a server's answers into messages. Unknown fields, which a newer server may send, are ignored.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>

#include "service.pb.h"

namespace tessera::client {

// Replaces `message`. Returns false when `json` is no object of this kind.
bool read_message(std::string_view json, google::protobuf::Message& message);

// The sentence of a problem, with marks for options when the daemon sends them (src/base/option.h).
const std::string& sentence_of(const proto::Problem& problem);

}  // namespace tessera::client
