// Names of threads, which `top -H`, `perf` and /proc/PID/task/TID/comm show. They tell what a process is busy with.
#pragma once

#include <pthread.h>

#include <cstddef>

namespace tessera {

// Names the calling thread. A name has at most 15 characters.
template <std::size_t size>
void name_thread(const char (&name)[size]) {
  static_assert(size <= 16, "the kernel keeps 15 characters");
  pthread_setname_np(pthread_self(), name);
}

}  // namespace tessera
