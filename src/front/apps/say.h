// Output of the command for people. It contains names and texts from files and servers, which could control a terminal.
// So all text goes through these functions. JSON, which is for programs, is printed as it is.
#pragma once

#include <string>

namespace tessera::apps {

// Print like printf, to stdout (say) or stderr (say_beside). Characters that are not printable (base/printable.h) are
// replaced; line ends stay.
[[gnu::format(printf, 1, 2)]] void say(const char* format, ...);
[[gnu::format(printf, 1, 2)]] void say_beside(const char* format, ...);
// Prints to stdout: text for people like say(), JSON as it is.
void say_whole(const std::string& text, bool is_json);

}  // namespace tessera::apps
