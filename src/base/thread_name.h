// Names of threads, as `top -H`, `perf` and /proc/PID/task/TID/comm tell them: what a process is busy with.
#pragma once

#include <pthread.h>

#include <cstddef>

namespace tessera {

// Names the calling thread; 15 characters at most.
template <std::size_t size>
void name_thread(const char (&name)[size]) {
  static_assert(size <= 16, "the kernel keeps 15 characters");
  pthread_setname_np(pthread_self(), name);
}

}  // namespace tessera
