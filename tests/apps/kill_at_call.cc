// Loaded before the C library: kills the process at its KILL_AT-th call that makes, renames or removes a file or a
// folder, before the call does anything. With KILL_AT_WRITES, calls that write or sync a file count, too.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace {

void count() {
  static const char* const at = std::getenv("KILL_AT");
  static std::atomic<long> calls{0};
  if (at != nullptr && ++calls == std::atol(at)) ::kill(::getpid(), SIGKILL);
}

void count_write() {
  static const bool counts = std::getenv("KILL_AT_WRITES") != nullptr;
  if (counts) count();
}

template <class Function>
Function* next(Function*, const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

#define COUNTED(name, parameters, arguments)      \
  extern "C" int name parameters noexcept {       \
    static auto* const real = next(&name, #name); \
    count();                                      \
    return real arguments;                        \
  }
COUNTED(mkdir, (const char* path, mode_t mode), (path, mode))
COUNTED(rename, (const char* from, const char* to), (from, to))
COUNTED(remove, (const char* path), (path))
COUNTED(unlink, (const char* path), (path))
COUNTED(unlinkat, (int folder, const char* path, int flags), (folder, path, flags))
COUNTED(rmdir, (const char* path), (path))

COUNTED(link, (const char* from, const char* to), (from, to))

extern "C" ssize_t write(int file, const void* from, size_t size) {
  static auto* const real = next(&write, "write");
  count_write();
  return real(file, from, size);
}

extern "C" ssize_t pwrite(int file, const void* from, size_t size, off_t at) {
  static auto* const real = next(&pwrite, "pwrite");
  count_write();
  return real(file, from, size, at);
}

extern "C" int fsync(int file) {
  static auto* const real = next(&fsync, "fsync");
  count_write();
  return real(file);
}

extern "C" int open(const char* path, int flags, ...) {
  static auto* const real = next(&open, "open");
  va_list more;
  va_start(more, flags);
  const bool makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  const mode_t mode = makes ? va_arg(more, mode_t) : 0;
  va_end(more);
  if (makes) count();
  return real(path, flags, mode);
}
