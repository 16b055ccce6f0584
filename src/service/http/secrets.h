// Random numbers that nobody guesses, and comparisons that tell nothing of them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera::http {

// `bytes` random bytes of the system, in hexadecimal.
std::string random_hex(std::size_t bytes);
// Tells a secret from every other without telling it (SHA-256, in hexadecimal). Of secrets that nobody can guess alone.
std::string checksum_of_secret(std::string_view secret);
// In a time that depends on the lengths alone.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace tessera::http
