// For our own mistakes: stops the process in every build, because a wrong cell is worse than none.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace tessera {

inline void check(bool holds, const char* what) {
  if (holds) [[likely]]
    return;
  std::fprintf(stderr, "tessera: internal error: %s\n", what);
  std::abort();
}

}  // namespace tessera
