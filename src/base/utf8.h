// Which bytes are UTF-8: names of files and texts of strangers may be anything.
#pragma once

#include <cstddef>
#include <string_view>

namespace tessera {

// Length of the valid UTF-8 sequence that begins `text`; 0 if there is none. Overlong forms, surrogates and code points
// beyond U+10FFFF are not valid.
std::size_t utf8_length(std::string_view text);
bool is_utf8(std::string_view text);

}  // namespace tessera
