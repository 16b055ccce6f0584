#include "tests/disk/failing_disk.h"

#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

namespace tessera::testing {
namespace {

std::atomic<bool> armed{false};
std::atomic<std::uint64_t> asked{0}, failed{0};
std::uint64_t first_to_fail = 0, last_to_fail = 0;
int number_to_give = 0;
std::string below;
std::mutex mutex;
std::set<std::string> synced;

bool is_below(std::string_view path) {
  return path.starts_with(below) && (path.size() == below.size() || path[below.size()] == '/');
}

bool refused() {
  const std::uint64_t now = ++asked;
  if (now < first_to_fail || now > last_to_fail) return false;
  ++failed;
  if (number_to_give == kill_process) ::kill(::getpid(), SIGKILL);
  errno = number_to_give;
  return true;
}

// Of an open file or folder, by a call of the system: none of ours.
std::string path_of(int file) {
  char path[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const int kept = errno;
  const long length = ::syscall(SYS_readlink, link.c_str(), path, sizeof path);
  errno = kept;
  return length > 0 ? std::string(path, static_cast<std::size_t>(length)) : "";
}

bool refuses(const char* path) { return armed.load() && path != nullptr && is_below(path) && refused(); }

bool refuses(int file) { return armed.load() && is_below(path_of(file)) && refused(); }

bool refuses(int folder, const char* path) {
  if (path != nullptr && path[0] == '/') return refuses(path);
  return folder != AT_FDCWD && refuses(folder);
}

void note_write(int file) {
  if (!armed.load()) return;
  const std::lock_guard lock(mutex);
  synced.erase(path_of(file));
}

void note_sync(int file, int result) {
  if (!armed.load() || result != 0) return;
  const std::lock_guard lock(mutex);
  synced.insert(path_of(file));
}

template <class Function>
Function* next(Function*, const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

void fail_below(const std::filesystem::path& folder, std::uint64_t first, std::uint64_t count, int number) {
  below = folder.string();
  first_to_fail = first;
  last_to_fail = count == 0 ? 0 : first + count - 1;
  number_to_give = number;
  asked = failed = 0;
  synced.clear();
  armed = true;
}

DiskCalls recover_disk() {
  armed = false;
  return {asked, failed};
}

bool was_synced(const std::filesystem::path& file) {
  const std::lock_guard lock(mutex);
  return synced.contains(file.string());
}

}  // namespace tessera::testing

namespace {
using tessera::testing::next;
using tessera::testing::note_sync;
using tessera::testing::note_write;
using tessera::testing::refuses;
}  // namespace

// In place of the C library's. `asks` is what the call is about.
#define REPLACED(type, name, parameters, arguments, asks, nothing) \
  type name parameters {                                           \
    static auto* const real = next(&name, #name);                  \
    if (refuses asks) return nothing;                              \
    return real arguments;                                         \
  }

extern "C" {

REPLACED(int, stat, (const char* path, struct stat* to) noexcept, (path, to), (path), -1)
REPLACED(int, lstat, (const char* path, struct stat* to) noexcept, (path, to), (path), -1)
REPLACED(int, fstat, (int file, struct stat* to) noexcept, (file, to), (file), -1)
REPLACED(int, fstat64, (int file, struct stat64* to) noexcept, (file, to), (file), -1)
REPLACED(int, fstatat, (int folder, const char* path, struct stat* to, int flags) noexcept, (folder, path, to, flags),
         (folder, path), -1)
REPLACED(int, access, (const char* path, int how) noexcept, (path, how), (path), -1)
REPLACED(int, mkdir, (const char* path, mode_t mode) noexcept, (path, mode), (path), -1)
REPLACED(int, rename, (const char* from, const char* to) noexcept, (from, to), (to), -1)
REPLACED(int, link, (const char* from, const char* to) noexcept, (from, to), (to), -1)
REPLACED(int, remove, (const char* path) noexcept, (path), (path), -1)
REPLACED(int, unlink, (const char* path) noexcept, (path), (path), -1)
REPLACED(int, unlinkat, (int folder, const char* path, int flags) noexcept, (folder, path, flags), (folder, path), -1)
REPLACED(int, rmdir, (const char* path) noexcept, (path), (path), -1)
REPLACED(int, ftruncate, (int file, off_t size) noexcept, (file, size), (file), -1)
REPLACED(DIR*, opendir, (const char* path), (path), (path), nullptr)
REPLACED(struct dirent*, readdir, (DIR * folder), (folder), (::dirfd(folder)), nullptr)
REPLACED(ssize_t, read, (int file, void* to, size_t size), (file, to, size), (file), -1)
REPLACED(ssize_t, pread, (int file, void* to, size_t size, off_t at), (file, to, size, at), (file), -1)

ssize_t write(int file, const void* from, size_t size) {
  static auto* const real = next(&write, "write");
  if (refuses(file)) return -1;
  note_write(file);
  return real(file, from, size);
}

ssize_t pwrite(int file, const void* from, size_t size, off_t at) {
  static auto* const real = next(&pwrite, "pwrite");
  if (refuses(file)) return -1;
  note_write(file);
  return real(file, from, size, at);
}

int fsync(int file) {
  static auto* const real = next(&fsync, "fsync");
  if (refuses(file)) return -1;
  const int result = real(file);
  note_sync(file, result);
  return result;
}

int fdatasync(int file) {
  static auto* const real = next(&fdatasync, "fdatasync");
  if (refuses(file)) return -1;
  const int result = real(file);
  note_sync(file, result);
  return result;
}

// The file is closed in any case.
int close(int file) {
  static auto* const real = next(&close, "close");
  const bool fails = refuses(file);
  const int number = errno;
  const int result = real(file);
  if (!fails) return result;
  errno = number;
  return -1;
}

int open(const char* path, int flags, ...) {
  static auto* const real = next(&open, "open");
  va_list more;
  va_start(more, flags);
  const bool makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  const mode_t mode = makes ? va_arg(more, mode_t) : 0;
  va_end(more);
  if (refuses(path)) return -1;
  return real(path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
  static auto* const real = next(&openat, "openat");
  va_list more;
  va_start(more, flags);
  const bool makes = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  const mode_t mode = makes ? va_arg(more, mode_t) : 0;
  va_end(more);
  if (refuses(folder, path)) return -1;
  return real(folder, path, flags, mode);
}

// What the headers make of the two above where flags are known only when the program runs.
int __open_2(const char* path, int flags);
int __open_2(const char* path, int flags) { return ::open(path, flags); }
int __openat_2(int folder, const char* path, int flags);
int __openat_2(int folder, const char* path, int flags) { return ::openat(folder, path, flags); }

}  // extern "C"
