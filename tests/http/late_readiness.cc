// Loaded before the C library: what epoll_wait() found is told up to 20 ms late, as by a thread that lost its processor
// just then. Meanwhile others may have read what it found.
#include <dlfcn.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <atomic>

extern "C" int epoll_wait(int set, epoll_event* events, int count, int timeout) {
  static const auto next = reinterpret_cast<decltype(&::epoll_wait)>(::dlsym(RTLD_NEXT, "epoll_wait"));
  static std::atomic<unsigned> calls{0};
  const int found = next(set, events, count, timeout);
  if (found > 0) ::usleep(calls++ * 7'919 % 20'000);
  return found;
}
