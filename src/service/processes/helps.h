// What the inputs of processes mean, for people.
#pragma once

#include <string_view>

namespace tessera::service {

// The help for a field of the messages of inputs in proto/service.proto; null when there is none, which a test forbids.
const char* help_of(std::string_view field);

}  // namespace tessera::service
