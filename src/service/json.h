// Converts messages to JSON as people and programs without protobuf write it: 64-bit numbers are numbers.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera::service {

// Returns one line. A field has its json_name, or its name in the .proto file when it has no json_name. Empty strings,
// and optional fields and messages that are not set, are left out; empty lists are written. Bytes that are not UTF-8
// become U+FFFD. REQUIRES: no fields of type bytes, no maps; doubles are finite.
std::string to_json(const google::protobuf::Message& message);

// Replaces `message`. Fields may have the names of to_json(), those of the .proto file, or camelCase names; null means
// not set; 64-bit numbers may be strings. Errors, all usage, name the field: an unknown name, a value of the wrong type
// or out of range, two values of a oneof; or the text is no JSON, no object, or nested more than 32 deep.
Status from_json(std::string_view json, google::protobuf::Message& message);

// True if lists and objects in the text are nested more than 32 deep; the text need not be valid JSON. Call this before
// parsing, because the parser needs memory for each level, and more to destroy the result.
bool nested_too_deep(std::string_view json);

// `text` with U+FFFD in place of what is not UTF-8, which no message may hold.
std::string as_utf8(std::string_view text);

}  // namespace tessera::service
