// What a server says, as messages. A newer one may say more than these have: that is passed over.
#pragma once

#include <google/protobuf/message.h>

#include <string_view>

namespace tessera {

// False when `json` is no object of this kind. Replaces `message`.
bool read_message(std::string_view json, google::protobuf::Message& message);

}  // namespace tessera
