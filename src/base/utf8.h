// Whether bytes are UTF-8. File names and foreign texts may contain any bytes.
#pragma once

#include <cstddef>
#include <string_view>

namespace tessera {

// Returns the length in bytes of the valid UTF-8 sequence that begins `text`, or 0 if there is none. Overlong forms,
// surrogates and code points above U+10FFFF are not valid. An empty text counts as one byte.
std::size_t utf8_length(std::string_view text);
bool is_utf8(std::string_view text);

}  // namespace tessera
