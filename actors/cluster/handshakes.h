// The rules of handshakes between nodes: TLS 1.3 or newer, whatever the system's configuration of OpenSSL permits. Also
// finds out what is wrong with a certificate when this process or the other side refuses a connection. CAF says only
// that there is no connection, so the reason is taken where OpenSSL knows it.
#pragma once

#include <openssl/ssl.h>

#include <chrono>
#include <string>
#include <vector>

namespace tessera {

// Call watch_handshake() before each step of a handshake, and note_failure() after each step and each read that has
// failed. False: this process cannot speak TLS 1.3, so there must be no handshake.
bool watch_handshake(SSL* ssl);
void note_failure(SSL* ssl);

// Returns what was found in this process since the last call, one sentence for each finding. The same sentence is not
// returned again for ten minutes, because a refused process tries again at once. Thread-safe.
std::vector<std::string> take_handshake_troubles(
    std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now());

}  // namespace tessera
