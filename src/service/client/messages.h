// What a server says, as messages. A newer one may say more than these have: that is passed over.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>

#include "service.pb.h"

namespace tessera {

// False when `json` is no object of this kind. Replaces `message`.
bool read_message(std::string_view json, google::protobuf::Message& message);

// What went wrong, with its options marked when the daemon says which they are (src/base/option.h).
const std::string& sentence_of(const proto::Problem& problem);

}  // namespace tessera
