// Random secrets, and comparisons that reveal nothing of them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera::service::http {

// `bytes` random bytes of the system, in hexadecimal.
std::string random_hex(std::size_t bytes);
// A checksum that identifies a secret without revealing it (SHA-256, in hexadecimal). Only for secrets that cannot be
// guessed.
std::string checksum_of_secret(std::string_view secret);
// Compares in a time that depends only on the lengths.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace tessera::service::http
