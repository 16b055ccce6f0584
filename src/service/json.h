// Messages as JSON, as people and programs without protobuf write it: 64-bit numbers are numbers.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>

#include "src/base/result.h"

namespace tessera {

// On one line. A field is called as its json_name says, and as in the .proto file when it has none of its own. Left out
// are strings that are empty, and optional fields and messages that are not there; lists are written when they are
// empty, too. Bytes that are not UTF-8 become U+FFFD.
// REQUIRES: no fields of type bytes, no maps; doubles are finite.
std::string to_json(const google::protobuf::Message& message);

// Replaces `message`. Fields may be called as to_json() calls them, as in the .proto file, or in camelCase; null is the
// same as nothing; 64-bit numbers may be strings, too. Errors, all usage, say which field: a name that the message does
// not have, a value of another type or out of range, two values of a oneof; text that is no JSON, that is no object, or
// in which lists and objects are nested more than 32 deep.
Status from_json(std::string_view json, google::protobuf::Message& message);

// Whether lists and objects are nested more than 32 deep, of text that may be no JSON at all. Before it is read:
// reading takes memory for each level, and more to throw it away.
bool nested_too_deep(std::string_view json);

// `text`, with U+FFFD for what is not UTF-8: no message may hold that.
std::string as_utf8(std::string_view text);

}  // namespace tessera
