// Two kinds of things that should never be: our own mistakes, which stop the process in every build, because a wrong
// cell is worse than none; and what only damaged or forged bytes of a disk or a peer can lead to, which ends the work
// on them.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace tessera {

inline void check(bool holds, const char* what) {
  if (holds) [[likely]]
    return;
  std::fprintf(stderr, "tessera: internal error: %s\n", what);
  std::abort();
}

// Thrown deep inside work on what was read, where an error as a value would have to pass through every step of an
// algorithm. Whoever has read the bytes catches it, and makes an error of it that names them.
struct Unsound : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// For what holds of all bytes that this program has written, and of no others.
inline void check_read(bool holds, const char* what) {
  if (!holds) [[unlikely]]
    throw Unsound(what);
}

}  // namespace tessera
