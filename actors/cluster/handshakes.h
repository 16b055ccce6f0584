// Finds out what is wrong with a certificate when this process or the other side refuses a connection. CAF says only
// that there is no connection, so the reason is taken where OpenSSL knows it.
#pragma once

#include <openssl/ssl.h>

#include <chrono>
#include <string>
#include <vector>

namespace tessera {

// Call watch_handshake() before each step of a handshake, and note_failure() after each step and each read that has
// failed.
void watch_handshake(SSL* ssl);
void note_failure(SSL* ssl);

// Returns what was found in this process since the last call, one sentence for each finding. The same sentence is not
// returned again for ten minutes, because a refused process tries again at once. Thread-safe.
std::vector<std::string> take_handshake_troubles(
    std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now());

}  // namespace tessera
