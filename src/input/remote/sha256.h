// SHA-256 of what a signed request sends (FIPS 180-4), by OpenSSL's libcrypto, which is loaded when it is needed: only
// programs that write objects need it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace tessera::remote {

// Returns 64 hexadecimal digits; nothing when libcrypto cannot be loaded. Of no bytes the digest is known without it.
// Thread-safe.
std::optional<std::string> sha256(std::span<const std::byte> bytes);

}  // namespace tessera::remote
