// What is wrong with a certificate when a connection is refused, here or by the other side. CAF says only that there is
// none: this is found where OpenSSL knows it.
#pragma once

#include <openssl/ssl.h>

#include <chrono>
#include <string>
#include <vector>

namespace tessera {

// Before each step of a handshake; after each step, and each read, that has failed.
void watch_handshake(SSL* ssl);
void note_failure(SSL* ssl);

// What has been found since this was asked last, in this process, a sentence each. The same one not again for ten
// minutes, for who is refused tries again at once.
std::vector<std::string> take_handshake_troubles(
    std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now());

}  // namespace tessera
