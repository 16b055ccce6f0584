// Checks for two kinds of things that must never be. check() is for bugs of this program: it ends the process in every
// build, because a wrong cell is worse than none. check_read() is for what only damaged or forged bytes from a disk or
// a peer can cause: it ends the work on these bytes by an exception.
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

// Thrown deep inside work on bytes that were read, where passing an error value through every step of an algorithm
// would cost too much. The code that read the bytes catches the exception and turns it into an error that names them.
struct Unsound : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// For conditions that hold for all bytes that this program has written, but need not hold for others.
inline void check_read(bool holds, const char* what) {
  if (!holds) [[unlikely]]
    throw Unsound(what);
}

}  // namespace tessera
