// What the command says to people. Names and texts of strangers are in it: so nothing goes to a terminal but by these
// (and JSON, which is for programs, as it is).
#pragma once

#include <string>

namespace tessera {

// Like printf, on stdout, and on stderr; what is not printable (base/printable.h) is replaced, line ends stay.
[[gnu::format(printf, 1, 2)]] void say(const char* format, ...);
[[gnu::format(printf, 1, 2)]] void say_beside(const char* format, ...);
// On stdout: a text for people like say(), JSON as it is.
void say_whole(const std::string& text, bool is_json);

}  // namespace tessera
